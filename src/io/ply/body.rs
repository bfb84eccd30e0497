//! From the data of a PLY file to a mesh.

use super::header::{Element, ElementKind, Header, Kind, Property, Role, Scalar};
use super::values::Values;
use crate::geometry::TriangleMesh;
use crate::io::mesh_file::MeshFile;
use crate::io::mesh_parts::PartsInOrder;
use crate::io::mesh_reading::{
    Corner, Malformed, Place, Seen, Tally, TooMany, Watch, capacity, split,
};
use crate::math::color::linear_from_srgb;
use crate::math::{DVec2, DVec3};

/// Reads what the header announces; `None` when cancelled.
///
/// # Errors
/// The first place where the data is not what the header announces.
pub fn read_body<V: Values>(
    header: &Header,
    values: V,
    watch: Watch,
) -> Result<Option<MeshFile>, Malformed> {
    let mut parts = PartsInOrder::default();
    let images = header.images.iter();
    let mut reader = Reader {
        values,
        watch,
        mesh: TriangleMesh::default(),
        wedges: header.has_wedges().then(Wedges::default),
        images: images.map(|image| parts.number(image.as_bytes())).collect(),
        parts,
        tally: Tally::default(),
        not_finite: Seen::default(),
        textures_not_finite: Seen::default(),
        indices: Vec::new(),
        on_image: Vec::new(),
    };
    if let Some(&first) = reader.images.first() {
        reader.parts.go_on(0, first);
    }
    for element in &header.elements {
        if reader.element(element)?.is_none() {
            return Ok(None);
        }
    }
    let trailing = reader.values.end()?;
    reader.finish(header, trailing)
}

/// The mesh read so far, and the data still to be read.
struct Reader<'a, V> {
    values: V,
    watch: Watch<'a>,
    mesh: TriangleMesh,
    /// Where faces have texture coordinates, in place of the mesh's triangles.
    wedges: Option<Wedges>,
    /// The numbers of the parts that show the images of the header.
    images: Vec<u32>,
    parts: PartsInOrder<'a>,
    tally: Tally,
    /// Normals that are not finite.
    not_finite: Seen,
    textures_not_finite: Seen,
    /// The vertices of the face or strip at hand.
    indices: Vec<u32>,
    /// Its texture coordinates, two numbers for each vertex, or others.
    on_image: Vec<f64>,
}

/// Faces whose corners have texture coordinates of their own.
#[derive(Default)]
struct Wedges {
    triangles: Vec<[Wedge; 3]>,
    /// The corners of the face at hand.
    corners: Vec<Wedge>,
    /// Faces that have no coordinates for all their corners.
    without: Seen,
}

#[derive(Clone, Copy)]
struct Wedge {
    position: u32,
    texture: DVec2,
}

impl Corner for Wedge {
    fn position(self) -> usize {
        self.position as usize
    }
}

/// One item of an element, for messages.
#[derive(Clone, Copy)]
struct Item<'a> {
    element: &'a Element,
    index: u64,
}

impl Item<'_> {
    fn name(self) -> String {
        let Self { element, index } = self;
        format!("{} {} of {}", element.kind.name(), index + 1, element.count)
    }
}

impl<V: Values> Reader<'_, V> {
    /// Reads an element; `None` when cancelled.
    fn element(&mut self, element: &Element) -> Result<Option<()>, Malformed> {
        // Items of nothing take no bytes, however many they are.
        if element.properties.is_empty() {
            return Ok(Some(()));
        }
        if element.kind == ElementKind::Vertex {
            let possible = self.values.remaining() / element.least_size();
            let capacity = capacity(element.count, possible);
            self.mesh.positions.reserve_exact(capacity);
            let has_normals = (0..3).all(|axis| element.has(Role::Normal(axis)));
            self.mesh.normals = has_normals.then(|| Vec::with_capacity(capacity));
            let has_texture = (0..2).all(|axis| element.has(Role::Texture(axis)));
            self.mesh.texture_coordinates = has_texture.then(|| Vec::with_capacity(capacity));
            let has_colors = (0..3).all(|channel| element.has(Role::Color(channel)));
            self.mesh.colors = has_colors.then(|| Vec::with_capacity(capacity));
        }
        for index in 0..element.count {
            let position = self.values.position();
            if self.watch.report_item(index, position).is_none() {
                return Ok(None);
            }
            let item = Item { element, index };
            let place = self.values.begin_item();
            match element.kind {
                ElementKind::Vertex => self.vertex(item, place)?,
                ElementKind::Face => {
                    self.read_indices(item)?;
                    self.add_face(place);
                }
                ElementKind::Strips => {
                    self.read_indices(item)?;
                    if self.add_strips(place).is_none() {
                        return Ok(None);
                    }
                }
                ElementKind::Other => {
                    for property in &element.properties {
                        self.skip(*property, item)?;
                    }
                    self.values.end_item(&|| item.name())?;
                }
            }
        }
        Ok(Some(()))
    }

    fn vertex(&mut self, item: Item, place: Place) -> Result<(), Malformed> {
        let (mut position, mut normal) = (DVec3::ZERO, DVec3::ZERO);
        let (mut texture, mut color) = (DVec2::ZERO, DVec3::ZERO);
        for property in &item.element.properties {
            match (property.role, property.kind) {
                (Role::Position(axis), Kind::One(scalar)) => {
                    let value = self.value(scalar, item)?;
                    if !value.is_finite() {
                        return Err(self.values.unexpected("a finite coordinate".to_owned()));
                    }
                    position[axis] = value;
                }
                (Role::Normal(axis), Kind::One(scalar)) => {
                    normal[axis] = self.value(scalar, item)?;
                }
                (Role::Texture(axis), Kind::One(scalar)) => {
                    texture[axis] = self.value(scalar, item)?;
                }
                (Role::Color(channel), Kind::One(scalar)) => {
                    color[channel] = self.value(scalar, item)? / scalar.white();
                }
                _ => self.skip(*property, item)?,
            }
        }
        self.values.end_item(&|| item.name())?;
        self.mesh.positions.push(position);
        if let Some(normals) = &mut self.mesh.normals {
            if !normal.is_finite() {
                self.not_finite.at(place);
                normal = DVec3::ZERO;
            }
            normals.push(normal);
        }
        if let Some(coordinates) = &mut self.mesh.texture_coordinates {
            if !texture.is_finite() {
                self.textures_not_finite.at(place);
                texture = DVec2::ZERO;
            }
            coordinates.push(texture);
        }
        if let Some(colors) = &mut self.mesh.colors {
            colors.push(color.as_vec3().map(linear_from_srgb));
        }
        Ok(())
    }

    fn value(&mut self, scalar: Scalar, item: Item) -> Result<f64, Malformed> {
        let value = self.values.next(scalar);
        value.ok_or_else(|| self.values.missing(item.name()))
    }

    fn list_length(&mut self, scalar: Scalar, item: Item) -> Result<u64, Malformed> {
        let value = self.value(scalar, item)?;
        as_index(value).map(u64::from).ok_or_else(|| {
            let expected = format!("the length of a list of {}", item.name());
            self.values.unexpected(expected)
        })
    }

    fn skip(&mut self, property: Property, item: Item) -> Result<(), Malformed> {
        let (count, scalar) = match property.kind {
            Kind::One(scalar) => (1, scalar),
            Kind::List { length, item: each } => (self.list_length(length, item)?, each),
        };
        let skipped = self.values.skip(count, scalar);
        skipped.ok_or_else(|| self.values.missing(item.name()))
    }

    /// Reads the vertices of a face or strip; in that, [`RESTART`] stands between its parts.
    fn read_indices(&mut self, item: Item) -> Result<(), Malformed> {
        let (kind, vertices) = (item.element.kind, self.mesh.positions.len());
        self.indices.clear();
        self.on_image.clear();
        // That there are too few numbers explains more than what the first of the next line means here.
        let mut first_wrong = None;
        for property in &item.element.properties {
            let (length, each) = match (property.role, property.kind) {
                (Role::Corners, Kind::List { length, item }) => (length, item),
                (Role::Wedges, Kind::List { length, item: each }) => {
                    for _ in 0..self.list_length(length, item)? {
                        let value = self.value(each, item)?;
                        self.on_image.push(value);
                    }
                    continue;
                }
                (Role::ImageNumber, Kind::One(scalar)) => {
                    let value = self.value(scalar, item)?;
                    self.show_image(value);
                    continue;
                }
                _ => {
                    self.skip(*property, item)?;
                    continue;
                }
            };
            for _ in 0..self.list_length(length, item)? {
                let value = self.value(each, item)?;
                let index = as_index(value).filter(|&index| (index as usize) < vertices);
                let restart = (kind == ElementKind::Strips && value == -1.0).then_some(RESTART);
                match index.or(restart) {
                    Some(index) => self.indices.push(index),
                    None if first_wrong.is_none() => {
                        let expected = format!("a vertex index below {vertices}");
                        first_wrong = Some(self.values.unexpected(expected));
                    }
                    None => {}
                }
            }
        }
        self.values.end_item(&|| item.name())?;
        first_wrong.map_or(Ok(()), Err)
    }

    /// The faces from the one at hand on show the image of this number in the header, or none where there is no such image.
    fn show_image(&mut self, number: f64) {
        if self.images.is_empty() {
            return;
        }
        let image = as_index(number).and_then(|number| self.images.get(number as usize));
        let part = image.copied().unwrap_or_else(|| self.parts.number(b""));
        let wedged = self.wedges.as_ref();
        let triangles = wedged.map_or(self.mesh.triangles.len(), |wedges| wedges.triangles.len());
        self.parts.go_on(triangles, part);
    }

    /// Adds the face at hand.
    fn add_face(&mut self, place: Place) {
        let mesh = &mut self.mesh;
        let Some(wedges) = &mut self.wedges else {
            let (positions, triangles) = (&mesh.positions, &mut mesh.triangles);
            self.tally
                .add_face(place, &mut self.indices, positions, triangles);
            return;
        };
        wedges.corners.clear();
        let (pairs, rest) = self.on_image.as_chunks::<2>();
        if pairs.len() == self.indices.len() && rest.is_empty() {
            let corners = self
                .indices
                .iter()
                .zip(pairs)
                .map(|(&position, &pair)| Wedge {
                    position,
                    texture: DVec2::from_array(pair),
                });
            wedges.corners.extend(corners);
        } else {
            wedges.without.at(place);
            let corners = self.indices.iter().map(|&position| Wedge {
                position,
                texture: DVec2::ZERO,
            });
            wedges.corners.extend(corners);
        }
        for corner in &mut wedges.corners {
            if !corner.texture.is_finite() {
                self.textures_not_finite.at(place);
                corner.texture = DVec2::ZERO;
            }
        }
        let (corners, triangles) = (&mut wedges.corners, &mut wedges.triangles);
        self.tally
            .add_face(place, corners, &mesh.positions, triangles);
    }

    /// Adds the triangles of the strips at hand; `None` when cancelled.
    fn add_strips(&mut self, place: Place) -> Option<()> {
        let indices = std::mem::take(&mut self.indices);
        let mut count = 0;
        for strip in indices.split(|&index| index == RESTART) {
            for (turn, &[a, b, c]) in strip.array_windows().enumerate() {
                count += 1;
                self.watch.report_item(count, self.values.position())?;
                if a == b || b == c || c == a {
                    continue;
                }
                self.indices.clear();
                self.indices
                    .extend(if turn % 2 == 0 { [a, b, c] } else { [b, a, c] });
                self.add_face(place);
            }
        }
        Some(())
    }

    /// Gives the mesh the triangles whose corners have texture coordinates of their own; `None` when cancelled.
    fn map_corners(&mut self, wedges: &Wedges) -> Result<Option<()>, Malformed> {
        let end = self.values.position() + self.values.remaining();
        let corners = wedges.triangles.iter();
        let corners =
            corners.map(|triangle| triangle.map(|Wedge { position, texture }| (position, texture)));
        let go_on = |index| self.watch.report_item(index, end);
        let mesh = &mut self.mesh;
        let split = split(mesh.positions.len(), corners, go_on).map_err(|TooMany| {
            let place = Place::Byte(end as u64);
            Malformed::at(place, "fewer than 2^32 vertices", "another")
        })?;
        let Some(split) = split else {
            return Ok(None);
        };
        split.extend(&mut mesh.positions);
        if let Some(normals) = &mut mesh.normals {
            split.extend(normals);
        }
        if let Some(colors) = &mut mesh.colors {
            split.extend(colors);
        }
        mesh.triangles = split.triangles;
        mesh.texture_coordinates = Some(split.attributes);
        Ok(Some(()))
    }

    /// The mesh with its parts; `None` when cancelled.
    fn finish(
        mut self,
        header: &Header,
        trailing: Option<String>,
    ) -> Result<Option<MeshFile>, Malformed> {
        let end = self.values.position() + self.values.remaining();
        let wedges = self.wedges.take();
        let are_hidden = wedges.is_some() && self.mesh.texture_coordinates.is_some();
        if let Some(wedges) = &wedges
            && self.map_corners(wedges)?.is_none()
        {
            return Ok(None);
        }
        // Cancelling comes too late here: the work is done.
        let _ = self.watch.report(end);
        let (mut colors, mut textures, mut others) =
            (Seen::default(), Seen::default(), Seen::default());
        for element in header.elements.iter().filter(|element| element.count > 0) {
            if element.kind == ElementKind::Other {
                others.at(Place::Line(element.line));
                continue;
            }
            for property in &element.properties {
                let line = Place::Line(property.line);
                match property.role {
                    Role::OtherColor => colors.at(line),
                    Role::OtherTexture => textures.at(line),
                    Role::Color(0) if self.mesh.colors.is_none() => colors.at(line),
                    Role::Texture(0) if self.mesh.texture_coordinates.is_none() => {
                        textures.at(line);
                    }
                    _ => {}
                }
            }
        }
        let warnings = [
            self.not_finite.counted(
                "normal that is not finite is ignored",
                "normals that are not finite are ignored",
            ),
            self.textures_not_finite.counted(
                "texture coordinate that is not finite is taken as (0, 0)",
                "texture coordinates that are not finite are taken as (0, 0)",
            ),
            wedges.and_then(|wedges| {
                wedges.without.counted(
                    "face has no texture coordinates at all corners; they are taken as (0, 0)",
                    "faces have no texture coordinates at all corners; they are taken as (0, 0)",
                )
            }),
            are_hidden.then(|| {
                "texture coordinates of vertices are ignored, as faces have their own".to_owned()
            }),
            colors.found("colours that vertices do not have whole are ignored"),
            textures.found("texture coordinates that vertices do not have whole are ignored"),
            others.counted(
                "element of another kind is ignored",
                "elements of other kinds are ignored",
            ),
            trailing,
        ];
        let warnings = warnings.into_iter().flatten();
        let file = self.tally.into_file("PLY", self.mesh, warnings);
        let is_mapped = file.mesh.texture_coordinates.is_some();
        Ok(Some(if is_mapped {
            MeshFile {
                parts: self.parts.into_parts(file.mesh.triangles.len()),
                parts_are_images: true,
                ..file
            }
        } else {
            file
        }))
    }
}

/// What stands between the parts of strips; as an index it is out of range, as there are fewer vertices.
const RESTART: u32 = u32::MAX;

/// The value if it is a whole number that fits.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "compared with the value afterwards"
)]
fn as_index(value: f64) -> Option<u32> {
    let index = value as u32;
    (f64::from(index) == value).then_some(index)
}
