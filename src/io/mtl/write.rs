//! Materials as MTL, in statements that this program reads back as the same kinds.

use std::io::{self, Write};

use crate::io::mesh_writing::Decimals;
use crate::scene::{Material, Rgb};

/// Writes materials with their names, such that reading them gives the same ones, apart from how glass absorbs, and images, which the
/// file must lie beside.
///
/// # Errors
/// What `out` returns.
pub fn write<'a>(
    materials: impl IntoIterator<Item = (&'a str, &'a Material)>,
    out: &mut dyn Write,
) -> io::Result<()> {
    for (name, material) in materials {
        writeln!(out, "newmtl {}", plain(name))?;
        match material {
            Material::Phong {
                diffuse,
                specular,
                shininess,
                ..
            } => {
                colors(out, *diffuse, *specular)?;
                writeln!(out, "Ns {}\nillum 2", Decimals(&[*shininess]))?;
            }
            Material::Mirror { reflectance } => {
                colors(out, Rgb::ZERO, *reflectance)?;
                writeln!(out, "illum 3")?;
            }
            Material::Glass { ior, .. } => {
                colors(out, Rgb::ZERO, Rgb::ZERO)?;
                writeln!(out, "d 0\nNi {}\nillum 7", Decimals(&[*ior]))?;
            }
            Material::Emitter { radiance } => {
                colors(out, Rgb::ZERO, Rgb::ZERO)?;
                writeln!(out, "Ke {}", Decimals(&radiance.to_array()))?;
            }
        }
        writeln!(out)?;
    }
    Ok(())
}

fn colors(out: &mut dyn Write, diffuse: Rgb, specular: Rgb) -> io::Result<()> {
    writeln!(out, "Kd {}", Decimals(&diffuse.to_array()))?;
    writeln!(out, "Ks {}", Decimals(&specular.to_array()))
}

/// `name` as a statement can hold it: on one line, without what begins a comment.
#[must_use]
pub fn plain(name: &str) -> String {
    let is_plain = |letter: char| !letter.is_control() && letter != '#';
    let plain: String = name
        .chars()
        .map(|letter| if is_plain(letter) { letter } else { '_' })
        .collect();
    match plain.trim() {
        "" => "_".to_owned(),
        trimmed => trimmed.to_owned(),
    }
}
