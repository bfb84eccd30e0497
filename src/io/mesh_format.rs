//! The formats of mesh files: which one a file has, and who reads and writes it.

use super::mesh_file::MeshFile;
use super::mesh_reading::Malformed;
use super::{gmsh, medit, obj, off, ply, stl};
use crate::control::{CancelToken, Progress};
use crate::geometry::TriangleMesh;
use std::ffi::OsStr;
use std::io::{self, Write};
use std::path::Path;

/// A format of one mesh in one file, which is read and written. (glTF, of many, is [`super::gltf`].)
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Object File Format of Geomview.
    Off,
    /// Wavefront's object files.
    Obj,
    /// Polygon File Format of Stanford.
    Ply,
    /// Stereolithography.
    Stl,
    /// Meshes of Medit, as simulations have them.
    Medit,
    /// Meshes of Gmsh, likewise.
    Gmsh,
}

/// The names of all formats that are read, for messages and file dialogs.
pub const READABLE_FORMATS: &str = "OFF, OBJ, PLY, STL, Medit, Gmsh and glTF";

/// File name extensions, in lower case, of these formats.
pub const READABLE_EXTENSIONS: &[&str] =
    &["off", "obj", "ply", "stl", "mesh", "msh", "gltf", "glb"];

impl MeshFormat {
    /// All formats.
    pub const ALL: [Self; 6] = [
        Self::Off,
        Self::Obj,
        Self::Ply,
        Self::Stl,
        Self::Medit,
        Self::Gmsh,
    ];

    /// The format that files with this name's extension have.
    #[must_use]
    pub fn of_extension(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_ascii_lowercase();
        Some(match extension.to_str()? {
            "off" => Self::Off,
            "obj" => Self::Obj,
            "ply" => Self::Ply,
            "stl" => Self::Stl,
            "mesh" => Self::Medit,
            "msh" => Self::Gmsh,
            _ => return None,
        })
    }

    /// The name, as people write it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "OFF",
            Self::Obj => "OBJ",
            Self::Ply => "PLY",
            Self::Stl => "STL",
            Self::Medit => "Medit",
            Self::Gmsh => "Gmsh",
        }
    }

    /// The format of a file: what its content says, and where that says nothing (an OFF file may begin with its counts) the
    /// extension of its name.
    ///
    /// # Errors
    /// When it is none of these; what it seems to be.
    pub(super) fn recognise(name: &str, bytes: &[u8]) -> Result<Self, String> {
        if off::has_keyword(bytes) {
            return Ok(Self::Off);
        }
        if ply::has_keyword(bytes) {
            return Ok(Self::Ply);
        }
        if stl::has_keyword(bytes) || stl::has_length(bytes) {
            return Ok(Self::Stl);
        }
        if medit::has_keyword(bytes) {
            return Ok(Self::Medit);
        }
        if gmsh::has_keyword(bytes) {
            return Ok(Self::Gmsh);
        }
        if let Some(format) = known_by_content(bytes) {
            return Err(format!("this is a file of the format {format}"));
        }
        if obj::has_keyword(bytes) {
            return Ok(Self::Obj);
        }
        let path = Path::new(name);
        Self::of_extension(path).ok_or_else(|| {
            let extension = path.extension().map(OsStr::to_ascii_lowercase);
            match extension.as_deref().map(OsStr::to_string_lossy).as_deref() {
                None => "this is not a mesh of a known format".to_owned(),
                // It would have been known by its content.
                Some("glb") => format!(
                    "this is not glTF, or it is damaged: binary glTF begins with \"glTF\", this file with \"{}\"",
                    bytes.get(..4).unwrap_or(bytes).escape_ascii()
                ),
                Some("gltf") => format!(
                    "this is not glTF, or it is damaged: the text of glTF begins with \"{{\", this file with \"{}\"",
                    bytes.get(..4).unwrap_or(bytes).escape_ascii()
                ),
                Some(other) => format!("files with the extension .{other} are not read"),
            }
        })
    }

    /// Reads a file of this format from its bytes; `None` when cancelled. `progress` advances by the bytes.
    ///
    /// # Errors
    /// The first place that breaks the format's rules.
    pub fn parse(
        self,
        bytes: &[u8],
        cancel: &CancelToken,
        progress: &Progress,
    ) -> Result<Option<MeshFile>, Malformed> {
        match self {
            Self::Off => off::parse(bytes, cancel, progress),
            Self::Obj => obj::parse(bytes, cancel, progress),
            Self::Ply => ply::parse(bytes, cancel, progress),
            Self::Stl => stl::parse(bytes, cancel, progress),
            Self::Medit => medit::parse(bytes, cancel, progress),
            Self::Gmsh => gmsh::parse(bytes, cancel, progress),
        }
    }

    /// Writes a mesh in this format. What it can hold reads back as it was, bit for bit.
    ///
    /// # Errors
    /// What `out` returns; and that the mesh is too large for the format.
    pub fn write(self, mesh: &TriangleMesh, out: &mut dyn Write) -> io::Result<()> {
        match self {
            Self::Off => off::write(mesh, out),
            Self::Obj => obj::write(mesh, out),
            Self::Ply => ply::write(mesh, out),
            Self::Stl => stl::write(mesh, out),
            Self::Medit => medit::write(mesh, out),
            Self::Gmsh => gmsh::write(mesh, out),
        }
    }

    /// What of the mesh [`MeshFormat::write`] leaves out, in sentences.
    #[must_use]
    pub fn losses(self, mesh: &TriangleMesh) -> Vec<String> {
        let holds_attributes = matches!(self, Self::Off | Self::Obj | Self::Ply);
        let attributes = [
            ("normals", mesh.normals.is_some()),
            ("texture coordinates", mesh.texture_coordinates.is_some()),
            ("colours", mesh.colors.is_some()),
        ];
        let attributes = attributes
            .into_iter()
            .filter(|&(_, is_there)| is_there && !holds_attributes);
        let attributes = attributes.map(|(what, _)| format!("{what} are"));
        let unused = if self == Self::Stl {
            unused_vertices(mesh)
        } else {
            0
        };
        let unused = match unused {
            0 => None,
            1 => Some("1 vertex without triangle is".to_owned()),
            _ => Some(format!("{unused} vertices without triangle are")),
        };
        let holds = match self {
            Self::Stl => "STL holds triangles alone".to_owned(),
            _ => format!("{} files are written without them", self.name()),
        };
        let lost = attributes.chain(unused);
        lost.map(|what| format!("{what} left out: {holds}"))
            .collect()
    }
}

/// How many vertices no triangle uses.
fn unused_vertices(mesh: &TriangleMesh) -> usize {
    let mut is_used = vec![false; mesh.positions.len()];
    for &vertex in mesh.triangles.iter().flatten() {
        is_used[vertex as usize] = true;
    }
    is_used.iter().filter(|is_used| !**is_used).count()
}

/// The format, known but without reader, whose first bytes these are.
fn known_by_content(bytes: &[u8]) -> Option<&'static str> {
    let formats: [(&[u8], &str); 7] = [
        (b"\x89PNG", "PNG"),
        (b"\x1f\x8b", "gzip, to be unpacked first"),
        (b"PK\x03\x04", "ZIP, to be unpacked first"),
        (b"Kaydara FBX Binary", "FBX"),
        (b"BLENDER", "Blender"),
        (b"\xff\xfe", "UTF-16, where UTF-8 is read"),
        (b"\xfe\xff", "UTF-16, where UTF-8 is read"),
    ];
    let starts = |(magic, _): &&(&[u8], &str)| bytes.starts_with(magic);
    formats.iter().find(starts).map(|(_, format)| *format)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes;
    use crate::math::color::linear_from_srgb;
    use crate::math::{DVec2, DVec3, Vec3};

    #[test]
    fn every_format_is_listed_where_users_look() {
        for (format, extension) in MeshFormat::ALL.into_iter().zip(READABLE_EXTENSIONS) {
            let path = Path::new("a").with_extension(extension.to_uppercase());
            assert_eq!(MeshFormat::of_extension(&path), Some(format));
            assert!(READABLE_FORMATS.contains(format.name()));
        }
        assert_eq!(
            READABLE_EXTENSIONS[MeshFormat::ALL.len()..],
            ["gltf", "glb"]
        );
    }

    /// A file is what its content says, whatever its name.
    #[test]
    fn what_is_written_is_known_by_its_content() {
        let mut mesh = shapes::icosphere(1);
        for round in 0..2 {
            for format in MeshFormat::ALL {
                let mut bytes = Vec::new();
                format.write(&mesh, &mut bytes).expect("a vector takes all");
                for name in ["a", "a.off", "a.obj", "a.ply", "a.stl", "a.mesh", "a.txt"] {
                    let known = MeshFormat::recognise(name, &bytes);
                    assert_eq!(known, Ok(format), "{name} {round}");
                }
            }
            // STL and PLY in 32 bits are other files.
            for position in &mut mesh.positions {
                *position = position.as_vec3().as_dvec3();
            }
        }
    }

    /// From each format to each and back: the same mesh, with its normals where all hold them.
    #[test]
    fn meshes_go_through_all_formats_unchanged() {
        let parse = |format: MeshFormat, bytes: &[u8]| -> TriangleMesh {
            let file = format.parse(bytes, &CancelToken::new(), &Progress::new());
            let file = file.expect("is right").expect("nobody cancels");
            assert_eq!(file.format, format.name());
            file.mesh
        };
        let through = |format: MeshFormat, mesh: &TriangleMesh| {
            let mut bytes = Vec::new();
            format.write(mesh, &mut bytes).expect("a vector takes all");
            parse(format, &bytes)
        };
        let round = shapes::icosphere(2);
        let short = TriangleMesh {
            positions: round
                .positions
                .iter()
                .map(|p| p.as_vec3().as_dvec3())
                .collect(),
            ..round.clone()
        };
        let extreme = TriangleMesh {
            positions: round.positions.iter().map(|&p| p * 1e-300).collect(),
            ..round.clone()
        };
        let mut with_normals = round.clone();
        with_normals.normals = Some(extreme.positions.clone());
        let holds_normals = |format: MeshFormat| {
            matches!(format, MeshFormat::Off | MeshFormat::Obj | MeshFormat::Ply)
        };
        for mesh in [round, short, extreme, with_normals] {
            for first in MeshFormat::ALL {
                for second in MeshFormat::ALL {
                    let read = through(second, &through(first, &mesh));
                    if [first, second].contains(&MeshFormat::Stl) {
                        let corners = |mesh: &TriangleMesh| -> Vec<_> {
                            (0..mesh.triangles.len()).map(|i| mesh.corners(i)).collect()
                        };
                        assert!(corners(&read) == corners(&mesh), "{first:?} {second:?}");
                        assert_eq!(read.normals, None);
                        assert!(read.colors.is_none() && read.texture_coordinates.is_none());
                    } else {
                        let mut expected = mesh.clone();
                        if !(holds_normals(first) && holds_normals(second)) {
                            expected.normals = None;
                        }
                        assert!(read == expected, "{first:?} {second:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn texture_coordinates_and_colors_go_through_the_formats_that_hold_them() {
        let mut mesh = shapes::icosphere(1);
        let coordinate = |p: &DVec3| DVec2::new(p.x / 3.0, p.y * 1e-20);
        mesh.texture_coordinates = Some(mesh.positions.iter().map(coordinate).collect());
        // What a byte stands for is kept as it is.
        let color = |index: usize| Vec3::new(index as f32, 7.0, 255.0 - index as f32) / 255.0;
        let linear = |index: usize| color(index).map(linear_from_srgb);
        mesh.colors = Some((0..mesh.positions.len()).map(linear).collect());
        for has_normals in [false, true] {
            mesh.normals = has_normals.then(|| mesh.positions.clone());
            for format in [MeshFormat::Off, MeshFormat::Obj, MeshFormat::Ply] {
                let mut bytes = Vec::new();
                format.write(&mesh, &mut bytes).expect("a vector takes all");
                let read = format.parse(&bytes, &CancelToken::new(), &Progress::new());
                let read = read.expect("is right").expect("nobody cancels");
                assert!(read.mesh == mesh, "{format:?}");
                assert_eq!(read.warnings, Vec::<String>::new());
            }
        }
    }

    #[test]
    fn what_a_format_does_not_hold_is_said() {
        let mut mesh = shapes::icosphere(0);
        assert!(
            MeshFormat::ALL
                .iter()
                .all(|format| format.losses(&mesh).is_empty())
        );
        mesh.positions.push(DVec3::ZERO);
        let unused = "1 vertex without triangle is left out: STL holds triangles alone";
        assert_eq!(MeshFormat::Stl.losses(&mesh), [unused]);
        mesh.positions.push(DVec3::ZERO);
        mesh.normals = Some(mesh.positions.clone());
        let expected = [
            "normals are left out: STL holds triangles alone",
            "2 vertices without triangle are left out: STL holds triangles alone",
        ];
        assert_eq!(MeshFormat::Stl.losses(&mesh), expected);
        assert_eq!(MeshFormat::Off.losses(&mesh), Vec::<String>::new());
        mesh.texture_coordinates = Some(vec![DVec2::ZERO; mesh.positions.len()]);
        mesh.colors = Some(vec![Vec3::ONE; mesh.positions.len()]);
        let expected = [
            "normals are left out: Medit files are written without them",
            "texture coordinates are left out: Medit files are written without them",
            "colours are left out: Medit files are written without them",
        ];
        assert_eq!(MeshFormat::Medit.losses(&mesh), expected);
        for format in [MeshFormat::Off, MeshFormat::Obj, MeshFormat::Ply] {
            assert_eq!(format.losses(&mesh), Vec::<String>::new());
        }
    }
}
