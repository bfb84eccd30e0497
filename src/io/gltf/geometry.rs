//! Meshes of a document as triangle meshes: one for each material that a mesh has.

use std::collections::{HashMap, HashSet};
use std::rc::Rc;
use std::sync::Arc;

use super::accessor::Data;
use super::document::{Attributes, Index, Mesh, Primitive};
use super::image_motion::ImageMotion;
use crate::geometry::TriangleMesh;
use crate::io::mesh_reading::{List, Malformed, Place, Seen, Tally, Watch};
use crate::math::{DVec2, DVec3, Vec3};
use crate::scene::UniqueNames;

/// The triangles of a mesh that have one material.
#[derive(Clone, Debug)]
pub struct Part {
    /// Differs from those of other parts of the file.
    pub name: String,
    /// Its geometry, shared with parts of the same accessors.
    pub mesh: Arc<TriangleMesh>,
    /// Its material, if it has one.
    pub material: Option<Index>,
}

/// Modes of primitives.
const TRIANGLES: u32 = 4;
const STRIP: u32 = 5;
const FAN: u32 = 6;

/// What the file holds and the meshes will not.
#[derive(Debug, Default)]
pub struct Notes {
    pub lines_and_points: Seen,
    pub without_positions: Seen,
    pub partly_normals: Seen,
    pub not_finite: Seen,
    pub morphed: Seen,
}

/// Reads meshes one after the other.
pub struct MeshReader<'a, 'd> {
    data: &'a Data<'d>,
    /// How many different primitives use each accessor as positions.
    uses: HashMap<Index, u32>,
    /// What was read last, as primitives beside each other often share it.
    positions: Recent<3>,
    normals: Recent<3>,
    textures: Recent<2>,
    /// Geometry of the same accessors.
    known: HashMap<Vec<Source>, Arc<TriangleMesh>>,
    /// The same with texture coordinates moved, by its address and the numbers that say how.
    moved: HashMap<(usize, [u64; 5]), Arc<TriangleMesh>>,
    names: UniqueNames,
    pub tally: Tally,
    pub notes: Notes,
}

/// Where the geometry of a primitive stands: attributes, indices and mode.
type Source = (Attributes, Option<Index>, u32);
fn source_of(primitive: &Primitive) -> Source {
    (primitive.attributes, primitive.indices, primitive.mode)
}

/// The elements of an accessor.
type Recent<const N: usize> = Option<(Index, Rc<Vec<[f64; N]>>)>;

impl<'a, 'd> MeshReader<'a, 'd> {
    pub fn new(data: &'a Data<'d>) -> Self {
        let primitives = data
            .document
            .meshes
            .iter()
            .flat_map(|mesh| &mesh.primitives);
        let different: HashSet<Source> = primitives.map(source_of).collect();
        let mut uses = HashMap::new();
        for position in different
            .iter()
            .filter_map(|(attributes, ..)| attributes.position)
        {
            *uses.entry(position).or_insert(0) += 1;
        }
        Self {
            data,
            uses,
            positions: None,
            normals: None,
            textures: None,
            known: HashMap::new(),
            moved: HashMap::new(),
            names: UniqueNames::default(),
            tally: Tally::default(),
            notes: Notes::default(),
        }
    }

    /// The parts of the mesh of number `index`; `None` when cancelled.
    pub fn parts(
        &mut self,
        index: Index,
        mesh: &Mesh,
        watch: &mut Watch<'_>,
    ) -> Result<Option<Vec<Part>>, Malformed> {
        let mut materials: Vec<(Option<Index>, Vec<&Primitive>)> = Vec::new();
        let mut numbers = HashMap::new();
        for primitive in &mesh.primitives {
            let number = *numbers.entry(primitive.material).or_insert(materials.len());
            if number == materials.len() {
                materials.push((primitive.material, Vec::new()));
            }
            materials[number].1.push(primitive);
        }
        let plain_name = match mesh.name.as_deref() {
            None | Some("") => format!("mesh {index}"),
            Some(name) => name.to_owned(),
        };
        let has_several = materials.len() > 1;
        let mut parts = Vec::new();
        for (material, primitives) in materials {
            let name = match (has_several, material) {
                (false, _) => plain_name.clone(),
                (true, None) => format!("{plain_name}/"),
                (true, Some(material)) => format!("{plain_name}/{}", self.material_name(material)),
            };
            let place = Place::Item(List::Meshes, index);
            let Some(mesh) = self.mesh(place, &primitives, watch)? else {
                return Ok(None);
            };
            let mesh = self.with_image_moved(place, mesh, material)?;
            parts.push(Part {
                name: self.names.unique(&name),
                mesh,
                material,
            });
        }
        Ok(Some(parts))
    }

    /// A name for a part that differs from all others.
    pub fn unique_name(&mut self, name: &str) -> String {
        self.names.unique(name)
    }

    /// The mesh with texture coordinates at which the images of its material are where that moves them.
    fn with_image_moved(
        &mut self,
        place: Place,
        mesh: Arc<TriangleMesh>,
        material: Option<Index>,
    ) -> Result<Arc<TriangleMesh>, Malformed> {
        let materials = &self.data.document.materials;
        let material = material.and_then(|index| materials.get(index as usize));
        let image = material.and_then(|material| {
            let normals = material.normal_texture.as_deref();
            material.color_texture().or(normals)
        });
        let moved = image.and_then(|image| ImageMotion::of(image.transform()?));
        let (Some(motion), Some(coordinates)) = (moved, &mesh.texture_coordinates) else {
            return Ok(mesh);
        };
        let key = (Arc::as_ptr(&mesh).addr(), motion.key());
        if let Some(known) = self.moved.get(&key) {
            return Ok(Arc::clone(known));
        }
        // Such copies count as what is read: many of one mesh would take more than the file accounts for.
        self.data.spend_vertices(place, coordinates.len() as u64)?;
        let coordinates = coordinates.iter().map(|&place| motion.apply(place));
        let moved = Arc::new(TriangleMesh {
            texture_coordinates: Some(coordinates.collect()),
            ..TriangleMesh::clone(&mesh)
        });
        self.moved.insert(key, Arc::clone(&moved));
        Ok(moved)
    }

    fn material_name(&self, material: Index) -> String {
        let named = self.data.document.materials.get(material as usize);
        let name = named.and_then(|material| material.name.clone());
        name.unwrap_or_else(|| material.to_string())
    }

    fn mesh(
        &mut self,
        place: Place,
        primitives: &[&Primitive],
        watch: &mut Watch<'_>,
    ) -> Result<Option<Arc<TriangleMesh>>, Malformed> {
        let source =
            |primitive: &&Primitive| (primitive.attributes, primitive.indices, primitive.mode);
        let key: Vec<Source> = primitives.iter().map(source).collect();
        if let Some(mesh) = self.known.get(&key) {
            return Ok(Some(Arc::clone(mesh)));
        }
        let mut all = Vertices::default();
        let mut triangles = Vec::new();
        for primitive in primitives {
            if self
                .add(place, primitive, &mut all, &mut triangles, watch)?
                .is_none()
            {
                return Ok(None);
            }
        }
        let (mesh, has_some_normals) = all.into_mesh(triangles);
        if has_some_normals {
            self.notes.partly_normals.at(place);
        }
        let mesh = Arc::new(mesh);
        self.known.insert(key, Arc::clone(&mesh));
        Ok(Some(mesh))
    }

    /// Adds the triangles of a primitive; `None` when cancelled.
    fn add(
        &mut self,
        place: Place,
        primitive: &Primitive,
        all: &mut Vertices,
        triangles: &mut Vec<[u32; 3]>,
        watch: &mut Watch<'_>,
    ) -> Result<Option<()>, Malformed> {
        self.check_not_compressed(place, primitive)?;
        if !(TRIANGLES..=FAN).contains(&primitive.mode) {
            self.notes.lines_and_points.at(place);
            return Ok(Some(()));
        }
        if !primitive.targets.is_empty() {
            self.notes.morphed.at(place);
        }
        let Some(position) = primitive.attributes.position else {
            self.notes.without_positions.at(place);
            return Ok(Some(()));
        };
        let source = self.source(position, primitive)?;
        let count = source.positions.len();
        let indices = primitive
            .indices
            .map(|index| self.data.indices(index))
            .transpose()?;
        let corners = indices.as_ref().map_or(count, Vec::len);
        let vertex = |corner: usize| {
            indices
                .as_ref()
                .map_or(u32::try_from(corner).ok(), |indices| Some(indices[corner]))
        };

        // Vertices that only this primitive uses stay as they are; of others, those that it does use.
        let is_alone = self.uses.get(&position) == Some(&1);
        let first = u32::try_from(all.positions.len() + count)
            .map(|end| end - u32::try_from(count).unwrap_or(end))
            .map_err(|_| Malformed::at(place, "fewer than 2^32 vertices", "more"))?;
        let mut taken = Taken::new(if is_alone { 0 } else { count }, corners);
        if is_alone {
            // A mesh may say the same primitive again and again.
            self.data.spend_vertices(place, count as u64)?;
            for vertex in 0..count {
                all.push(&source, vertex, &mut self.notes, place)?;
            }
        }
        let triangle_count = match primitive.mode {
            TRIANGLES => corners / 3,
            _ => corners.saturating_sub(2),
        };
        let mut face = Vec::with_capacity(3);
        for index in 0..triangle_count {
            if watch.go_on(index as u64).is_none() {
                return Ok(None);
            }
            let three = match primitive.mode {
                TRIANGLES => [3 * index, 3 * index + 1, 3 * index + 2],
                // Every second one is turned, so that all face the same way.
                STRIP => [index, index + 1 + index % 2, index + 2 - index % 2],
                _ => [index + 1, index + 2, 0],
            };
            face.clear();
            for corner in three {
                let found = vertex(corner).unwrap_or(NONE);
                if found as usize >= count {
                    let place = primitive
                        .indices
                        .map_or(place, |index| Place::Item(List::Accessors, index));
                    return Err(Malformed::at(
                        place,
                        format!("indices below {count}"),
                        found.to_string(),
                    ));
                }
                let number = if is_alone {
                    first + found
                } else {
                    let known = taken.get(found);
                    if known.is_none() {
                        let new = all.push(&source, found as usize, &mut self.notes, place)?;
                        taken.set(found, new);
                    }
                    taken.get(found).unwrap_or(NONE)
                };
                face.push(number);
            }
            self.tally
                .add_face(place, &mut face, &all.positions, triangles);
        }
        Ok(Some(()))
    }

    /// Says that a primitive is compressed, where it has no other data.
    fn check_not_compressed(&self, place: Place, primitive: &Primitive) -> Result<(), Malformed> {
        let document = self.data.document;
        let accessor = primitive.attributes.position;
        let accessor = accessor.and_then(|index| document.accessors.get(index as usize));
        let view = accessor.and_then(|accessor| accessor.buffer_view);
        if primitive.extensions.draco.is_none() || view.is_some() {
            return Ok(());
        }
        let expected = "a mesh that is not compressed";
        Err(Malformed::at(place, expected, "one compressed by Draco"))
    }

    /// The elements that a primitive's vertices have.
    fn source(&mut self, position: Index, primitive: &Primitive) -> Result<Elements, Malformed> {
        let data = self.data;
        let Attributes {
            normal,
            texture,
            color,
            ..
        } = primitive.attributes;
        let positions = recent(
            data,
            &mut self.positions,
            position,
            "positions of type VEC3",
        )?;
        let normals =
            normal.map(|index| recent(data, &mut self.normals, index, "normals of type VEC3"));
        let textures = texture.map(|index| {
            recent(
                data,
                &mut self.textures,
                index,
                "texture coordinates of type VEC2",
            )
        });
        let elements = Elements {
            normals: normals.transpose()?,
            textures: textures.transpose()?,
            colors: color.map(|index| colors(data, index)).transpose()?,
            positions,
        };
        let count = elements.positions.len();
        let counts = [
            (normal, elements.normals.as_ref().map(|list| list.len())),
            (texture, elements.textures.as_ref().map(|list| list.len())),
            (color, elements.colors.as_ref().map(Vec::len)),
        ];
        for (accessor, found) in counts {
            if let (Some(accessor), Some(found)) = (accessor, found.filter(|&found| found < count))
            {
                let expected = format!("an element for each of {count} vertices");
                return Err(Malformed::at(
                    Place::Item(List::Accessors, accessor),
                    expected,
                    found.to_string(),
                ));
            }
        }
        Ok(elements)
    }
}

/// Stands for no vertex.
const NONE: u32 = u32::MAX;

/// Which numbers the vertices got that were taken so far.
enum Taken {
    All(Vec<u32>),
    /// Where few of very many are: room for all would be made again for each primitive that shares them.
    Few(HashMap<u32, u32>),
}

impl Taken {
    /// None so far, of `count` vertices for so many `corners`.
    fn new(count: usize, corners: usize) -> Self {
        if corners < count {
            Self::Few(HashMap::new())
        } else {
            Self::All(vec![NONE; count])
        }
    }

    fn get(&self, vertex: u32) -> Option<u32> {
        match self {
            Self::All(numbers) => Some(numbers[vertex as usize]).filter(|&number| number != NONE),
            Self::Few(numbers) => numbers.get(&vertex).copied(),
        }
    }

    fn set(&mut self, vertex: u32, number: u32) {
        match self {
            Self::All(numbers) => numbers[vertex as usize] = number,
            Self::Few(numbers) => {
                numbers.insert(vertex, number);
            }
        }
    }
}

/// The elements of an accessor, which are those read last where it is the same.
fn recent<const N: usize>(
    data: &Data<'_>,
    recent: &mut Recent<N>,
    index: Index,
    expected: &str,
) -> Result<Rc<Vec<[f64; N]>>, Malformed> {
    if let Some((known, elements)) = recent
        && *known == index
    {
        return Ok(Rc::clone(elements));
    }
    // Room for the next ones.
    *recent = None;
    let elements = Rc::new(data.vectors::<N>(index, expected)?);
    *recent = Some((index, Rc::clone(&elements)));
    Ok(elements)
}

/// Colours of three or four channels; an alpha means nothing here.
fn colors(data: &Data<'_>, index: Index) -> Result<Vec<Vec3>, Malformed> {
    const EXPECTED: &str = "colours of type VEC3 or VEC4";
    let has_alpha = data
        .document
        .accessors
        .get(index as usize)
        .is_some_and(|accessor| accessor.kind == "VEC4");
    let color = |[r, g, b]: [f64; 3]| DVec3::new(r, g, b).as_vec3();
    Ok(if has_alpha {
        let elements = data.vectors::<4>(index, EXPECTED)?;
        elements
            .into_iter()
            .map(|[r, g, b, _]| color([r, g, b]))
            .collect()
    } else {
        data.vectors::<3>(index, EXPECTED)?
            .into_iter()
            .map(color)
            .collect()
    })
}

/// What the vertices of a primitive have, one for each.
struct Elements {
    positions: Rc<Vec<[f64; 3]>>,
    normals: Option<Rc<Vec<[f64; 3]>>>,
    textures: Option<Rc<Vec<[f64; 2]>>>,
    colors: Option<Vec<Vec3>>,
}

/// The vertices of a part so far. Lists that only some primitives have are filled up.
#[derive(Default)]
struct Vertices {
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    textures: Vec<DVec2>,
    colors: Vec<Vec3>,
}

impl Vertices {
    /// Adds a vertex and returns its number.
    fn push(
        &mut self,
        source: &Elements,
        vertex: usize,
        notes: &mut Notes,
        place: Place,
    ) -> Result<u32, Malformed> {
        let number = self.positions.len();
        let position = DVec3::from_array(source.positions[vertex]);
        if !position.is_finite() {
            let found = format!("({}, {}, {})", position.x, position.y, position.z);
            return Err(Malformed::at(place, "finite coordinates", found));
        }
        self.positions.push(position);
        if let Some(normals) = &source.normals {
            let normal = DVec3::from_array(normals[vertex]);
            if !normal.is_finite() {
                notes.not_finite.at(place);
            }
            self.normals.push(if normal.is_finite() {
                normal
            } else {
                DVec3::ZERO
            });
        }
        if let Some(textures) = &source.textures {
            let [u, v] = textures[vertex];
            // Images begin at their top there, and at their bottom here.
            let coordinate = DVec2::new(u, 1.0 - v);
            if !coordinate.is_finite() {
                notes.not_finite.at(place);
            }
            self.textures.resize(number, DVec2::ZERO);
            self.textures.push(if coordinate.is_finite() {
                coordinate
            } else {
                DVec2::ZERO
            });
        }
        if let Some(colors) = &source.colors {
            let color = colors[vertex];
            self.colors.resize(number, Vec3::ONE);
            self.colors.push(if color.is_finite() {
                color.clamp(Vec3::ZERO, Vec3::ONE)
            } else {
                Vec3::ONE
            });
        }
        u32::try_from(number)
            .ok()
            .filter(|&number| number != NONE)
            .ok_or_else(|| Malformed::at(place, "fewer than 2^32 vertices", "more"))
    }

    /// The mesh, and whether some vertices have normals that others do not have.
    fn into_mesh(mut self, mut triangles: Vec<[u32; 3]>) -> (TriangleMesh, bool) {
        let count = self.positions.len();
        let has_normals = count > 0 && self.normals.len() == count;
        let has_some_normals = !has_normals && !self.normals.is_empty();
        if !self.textures.is_empty() {
            self.textures.resize(count, DVec2::ZERO);
        }
        if !self.colors.is_empty() {
            self.colors.resize(count, Vec3::ONE);
        }
        triangles.shrink_to_fit();
        let mesh = TriangleMesh {
            positions: self.positions,
            triangles,
            normals: has_normals.then_some(self.normals),
            texture_coordinates: (!self.textures.is_empty()).then_some(self.textures),
            colors: (!self.colors.is_empty()).then_some(self.colors),
        };
        (mesh, has_some_normals)
    }
}
