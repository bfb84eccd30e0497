//! From materials of glTF to the scene's four kinds.

use super::document::{
    Material as Source, MaterialExtensions, MetallicRoughness, SpecularGlossiness,
};
use crate::io::remarks::Remarks;
use crate::scene::{Material, Rgb, Textures};

/// Smoother metals are mirrors.
const MIRROR_ROUGHNESS: f64 = 0.05;
/// Share of metal, or of light let through, from which on a material is taken for metal or glass.
const HALF: f64 = 0.5;
/// What a surface of index 1.5, that of plastics, reflects at right angles.
const PLASTIC: f64 = 0.04;
/// The darkest colour that light fades to: no finite fading makes black.
const DARKEST: f64 = 1e-6;

/// The exponent of the Phong lobe that is as wide as the reflection of a surface of this roughness.
///
/// `α = roughness²` by the specification of glTF. A lobe about the half vector of width α has the exponent 2/α² − 2 (Walter et al. 2007,
/// Microfacet Models for Refraction, section 5.2), and one about the mirror direction, whose angle is twice as large, a quarter of it
/// (Fisher & Woo 1994, R.E versus N.H Specular Highlights).
#[must_use]
pub fn shininess_of(roughness: f64) -> f64 {
    let alpha = roughness * roughness;
    let alpha_squared = alpha * alpha;
    ((1.0 / alpha_squared - 1.0) / 2.0).clamp(0.0, Material::MAX_SHININESS)
}

/// The roughness for which [`shininess_of`] is `shininess`.
#[must_use]
pub fn roughness_of(shininess: f64) -> f64 {
    libm::sqrt(libm::sqrt(1.0 / (2.0 * shininess + 1.0)))
}

/// The material of the scene that is nearest. The first of these that holds, where B is the base colour, m the share of metal and r the
/// roughness:
///
/// 1. An emitter of `emissiveFactor` × `emissiveStrength`, where that is more than 0, no image says where, and no channel of what the
///    material reflects diffusely is larger than its largest one.
/// 2. Glass, where at least half of the light is let through (`KHR_materials_transmission`): of the index of `KHR_materials_ior`, and
///    fading as `KHR_materials_volume` says: −ln(colour) / distance.
/// 3. A mirror of reflectance B, where m is at least 0.5 and r below 0.05.
/// 4. Phong: what is reflected at right angles, P = 0.04 · specular of what is no metal and B of what is, is its specular reflectance,
///    (1 − m) · P + m · B, and B · (1 − m) · (1 − P) its diffuse one, as the specification (appendix B) has it; the exponent is that of
///    [`shininess_of`] r.
///
/// Where `KHR_materials_pbrSpecularGlossiness` says what is reflected, that holds in place of B, m and r.
///
/// `textures` vary a material of Phong. Where m and r come from an image, the material is taken for no metal of the roughness that it
/// states. What is changed or left out, `remarks` say of the material called `name`.
#[must_use]
pub fn to_material(
    source: &Source,
    textures: Textures,
    name: &str,
    remarks: &mut Remarks,
) -> Material {
    let no_extensions = MaterialExtensions::default();
    let extensions = source.extensions.as_deref().unwrap_or(&no_extensions);
    let usual = MetallicRoughness::default();
    let surface = source.pbr_metallic_roughness.as_deref().unwrap_or(&usual);
    let [r, g, b, _] = surface.base_color_factor.unwrap_or([1.0; 4]);
    let base = clamped(Rgb::new(r, g, b));
    let by_image = surface.both_by_texture.is_some();
    let metal = if by_image {
        0.0
    } else {
        share(surface.metallic_factor, 1.0)
    };
    let roughness = share(surface.roughness_factor, 1.0);
    let glossiness = extensions.glossiness.as_deref();
    if by_image && glossiness.is_none() {
        remarks.add(
            name,
            "metal and roughness by an image are not shown; it is taken for no metal",
        );
    }
    if extensions.unlit.is_some() {
        remarks.add(name, "is to be shown without light; it is lit here");
    }

    let reflected_by_plastic =
        extensions
            .specular
            .as_ref()
            .map_or(Rgb::splat(PLASTIC), |specular| {
                let color = Rgb::from_array(specular.specular_color_factor.unwrap_or([1.0; 3]));
                clamped(color * PLASTIC) * share(specular.specular_factor, 1.0)
            });
    let specular = reflected_by_plastic * (1.0 - metal) + base * metal;
    let diffuse = base * (1.0 - metal) * (1.0 - reflected_by_plastic.max_element());
    let (diffuse, specular, metal, roughness) = match glossiness {
        Some(glossiness) => of_glossiness(glossiness, name, remarks),
        None => (diffuse, specular, metal, roughness),
    };

    let emission = not_negative(Rgb::from_array(source.emissive_factor.unwrap_or_default()));
    let strength = extensions
        .emissive_strength
        .as_ref()
        .and_then(|emission| emission.emissive_strength);
    let emission = emission * strength.filter(|strength| *strength >= 0.0).unwrap_or(1.0);
    if emission.max_element() > 0.0 {
        let is_everywhere = source.emissive_texture.is_none();
        if is_everywhere && emission.is_finite() && diffuse.max_element() <= emission.max_element()
        {
            return Material::Emitter { radiance: emission };
        }
        let what = if is_everywhere {
            "shines less than it reflects; it only reflects here"
        } else {
            "shines where an image says; it only reflects here"
        };
        remarks.add(name, what);
    }

    let transmission = extensions
        .transmission
        .as_ref()
        .map_or(0.0, |transmission| transmission.transmission_factor);
    if transmission >= HALF {
        return glass(extensions);
    }
    if source
        .alpha_mode
        .as_deref()
        .is_some_and(|mode| mode == "MASK" || mode == "BLEND")
    {
        remarks.add(
            name,
            "lets light through without being glass; it is opaque here",
        );
    }
    if metal >= HALF && roughness < MIRROR_ROUGHNESS {
        return Material::Mirror { reflectance: base };
    }
    Material::Phong {
        diffuse,
        specular,
        shininess: shininess_of(roughness),
        textures,
    }
}

/// What a material reflects diffusely and not, its share of metal, and its roughness, as older files say it. Source: Khronos,
/// `KHR_materials_pbrSpecularGlossiness`.
fn of_glossiness(
    glossiness: &SpecularGlossiness,
    name: &str,
    remarks: &mut Remarks,
) -> (Rgb, Rgb, f64, f64) {
    if glossiness.both_by_texture.is_some() {
        remarks.add(
            name,
            "highlights and glossiness by an image are not shown; it has those that it states",
        );
    }
    let [r, g, b, _] = glossiness.diffuse_factor.unwrap_or([1.0; 4]);
    let specular = Rgb::from_array(glossiness.specular_factor.unwrap_or([1.0; 3]));
    // An image multiplies what is stated, which is white where nothing is.
    let specular = if glossiness.both_by_texture.is_some() {
        clamped(specular) * PLASTIC
    } else {
        clamped(specular)
    };
    let diffuse = clamped(Rgb::new(r, g, b)) * (1.0 - specular.max_element());
    let roughness = 1.0 - share(glossiness.glossiness_factor, 1.0);
    (diffuse, specular, 0.0, roughness)
}

fn glass(extensions: &MaterialExtensions) -> Material {
    let ior = extensions.ior.as_ref().and_then(|ior| ior.ior);
    let attenuation = extensions.volume.as_ref().and_then(|volume| {
        let distance = volume
            .attenuation_distance
            .filter(|distance| *distance > 0.0 && distance.is_finite())?;
        let color = clamped(Rgb::from_array(
            volume.attenuation_color.unwrap_or([1.0; 3]),
        ));
        // The logarithm of 1 is 0, and no light is to be lost by its sign.
        Some(
            color
                .max(Rgb::splat(DARKEST))
                .map(|channel| 0.0 - libm::log(channel) / distance),
        )
    });
    Material::Glass {
        ior: ior
            .filter(|ior| (1.0..=Material::MAX_IOR).contains(ior))
            .unwrap_or(Material::USUAL_IOR),
        attenuation: attenuation
            .filter(|fading| fading.is_finite())
            .unwrap_or(Rgb::ZERO),
    }
}

/// A factor from 0 to 1.
fn share(value: Option<f64>, usual: f64) -> f64 {
    value
        .filter(|value| !value.is_nan())
        .unwrap_or(usual)
        .clamp(0.0, 1.0)
}

fn clamped(color: Rgb) -> Rgb {
    not_negative(color).min(Rgb::ONE)
}

/// The colour with 0 for what is no number or negative.
fn not_negative(color: Rgb) -> Rgb {
    color.map(|channel| if channel > 0.0 { channel } else { 0.0 })
}
