//! From what an MTL file says of a material to one of the scene's four kinds.

use crate::io::remarks::Remarks;
use crate::scene::{Material, Rgb, Textures};

/// A material as an MTL file states it; `None` is not stated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MtlMaterial {
    /// `Kd`, 0 or more.
    pub diffuse: Option<Rgb>,
    /// `Ks`, 0 or more.
    pub specular: Option<Rgb>,
    /// `Ke`, 0 or more.
    pub emission: Option<Rgb>,
    /// `Ns`, 0 or more.
    pub shininess: Option<f64>,
    /// `Ni`, 0 or more.
    pub ior: Option<f64>,
    /// `d`, or 1 − `Tr`: from 0, nothing is there, to 1.
    pub opacity: Option<f64>,
    /// `illum`.
    pub illumination: Option<u64>,
    /// `map_Kd`: an image in place of `diffuse`.
    pub diffuse_image: Option<String>,
    /// `norm`, `map_Bump` or `bump`. Where it turns out to be of heights, as the last two once were, it is left out when it is loaded.
    pub normal_image: Option<String>,
}

/// Models of illumination whose surfaces reflect what is around them.
const REFLECTING: [u64; 3] = [3, 5, 8];
/// Models that refract, whatever the opacity says.
const REFRACTING: [u64; 2] = [6, 7];
/// Models of glass, where the surface lets light through.
const OF_GLASS: [u64; 2] = [4, 9];
/// Models without highlight.
const MATT: [u64; 2] = [0, 1];

impl MtlMaterial {
    /// The material of the scene that is nearest. The first of these that holds:
    ///
    /// 1. An emitter of radiance `Ke`, where that is more than 0 and no channel of `Kd` is larger than its largest one.
    /// 2. Glass of index `Ni` (1.5 where that is 1 or not stated), where `illum` is 6 or 7, or where the surface lets light through
    ///    (`d` below 1) and `illum` is 4 or 9 or `Ni` is neither 0 nor 1.
    /// 3. A mirror of reflectance `Ks`, where `illum` is 3, 5 or 8 and no channel of `Kd` is larger than the largest one of `Ks`.
    /// 4. Phong of `Kd`, `Ks` and `Ns`; without highlight where `illum` is 0 or 1. Where the two reflect more light than arrives, `Kd`
    ///    is cut at 1 and `Ks` at what is left to 1.
    ///
    /// The images stay names, relative to the file; Kd, white where it is black or not stated beside `map_Kd`, multiplies that.
    ///
    /// What is changed or left out by that, `remarks` say of the material called `name`.
    #[must_use]
    pub fn to_material(&self, name: &str, remarks: &mut Remarks) -> Material {
        let Material::Phong {
            diffuse: usual_diffuse,
            shininess: usual_shininess,
            ..
        } = Material::default()
        else {
            unreachable!("the default material is Phong");
        };
        let illuminated_as = |models: &[u64]| {
            self.illumination
                .is_some_and(|model| models.contains(&model))
        };
        let has_image = self.diffuse_image.is_some();
        // An image is multiplied; programs that write black beside one mean the image alone.
        let diffuse = match self
            .diffuse
            .filter(|diffuse| !has_image || *diffuse != Rgb::ZERO)
        {
            None if has_image => Rgb::ONE,
            stated => stated.unwrap_or(usual_diffuse),
        };
        let specular = self.specular.unwrap_or(Rgb::ZERO);

        let emission = self.emission.unwrap_or(Rgb::ZERO);
        if emission.max_element() > 0.0 {
            if diffuse.max_element() <= emission.max_element() {
                return Material::Emitter { radiance: emission };
            }
            remarks.add(name, "shines less than it reflects; it only reflects here");
        }

        let lets_through = self.opacity.is_some_and(|opacity| opacity < 1.0);
        let bends = self.ior.is_some_and(|ior| ior != 0.0 && ior != 1.0);
        let is_glass =
            illuminated_as(&REFRACTING) || (lets_through && (bends || illuminated_as(&OF_GLASS)));
        if is_glass {
            let allowed = Material::MIN_IOR..=Material::MAX_IOR;
            let stated = self.ior.filter(|ior| bends && allowed.contains(ior));
            return Material::Glass {
                ior: stated.unwrap_or(Material::USUAL_IOR),
                attenuation: Rgb::ZERO,
            };
        }
        if lets_through {
            remarks.add(
                name,
                "lets light through without being glass; it is opaque here",
            );
        }

        let reflects =
            specular.max_element() > 0.0 && diffuse.max_element() <= specular.max_element();
        if illuminated_as(&REFLECTING) && reflects {
            return Material::Mirror {
                reflectance: specular.min(Rgb::ONE),
            };
        }
        let textures = Textures {
            diffuse_image: self.diffuse_image.clone(),
            normal_image: self.normal_image.clone(),
            vertex_colors: false,
        };
        let specular = if illuminated_as(&MATT) {
            Rgb::ZERO
        } else {
            specular
        };
        let (diffuse, specular) = within_energy(diffuse, specular, name, remarks);
        let shininess = self.shininess.unwrap_or(usual_shininess);
        Material::Phong {
            diffuse,
            specular,
            shininess: shininess.min(Material::MAX_SHININESS),
            textures,
        }
    }
}

/// Reflectances that reflect no more light than arrives.
fn within_energy(diffuse: Rgb, specular: Rgb, name: &str, remarks: &mut Remarks) -> (Rgb, Rgb) {
    let kept_diffuse = diffuse.min(Rgb::ONE);
    let kept_specular = specular.min(Rgb::ONE - kept_diffuse);
    if (kept_diffuse, kept_specular) != (diffuse, specular) {
        remarks.add(
            name,
            "reflects more light than arrives (Kd + Ks above 1); Ks is lowered to what Kd leaves",
        );
    }
    (kept_diffuse, kept_specular)
}
