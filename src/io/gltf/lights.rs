//! Lights and cameras of a document.

use super::accessor::beyond;
use super::document::{Document, Index};
use super::nodes::{Affine, Placed};
use crate::io::mesh_reading::{List, Malformed};
use crate::io::remarks::Remarks;
use crate::math::{DBounds, DVec3, Degrees, direction_of};
use crate::scene::{Camera, Facing, Light, NamedLight, Rgb};

/// Radius of the disk that stands for a spot light, in units of the file, which are metres.
const SPOT_RADIUS: f64 = 0.01;
/// How far away the point is that stands for a directional light, in sizes of all objects: its light differs by a five-thousandth from one
/// end of them to the other.
const FAR: f64 = 1e4;

/// The lights of nodes and the first camera. `around`: the box of all objects.
///
/// # Errors
/// A light or camera that is not there.
pub fn of_nodes(
    document: &Document,
    placed: &[Placed],
    around: &DBounds,
    remarks: &mut Remarks,
) -> Result<(Vec<NamedLight>, Option<Camera>), Malformed> {
    let mut lights = Vec::new();
    let mut camera = None;
    for Placed { node, world } in placed {
        let node_record = &document.nodes[*node as usize];
        let extensions = node_record.extensions.as_deref();
        if let Some(light) = extensions.and_then(|extensions| extensions.light.as_ref()) {
            let name = node_record.name.as_deref();
            let shown = name.map_or_else(|| format!("nodes[{node}]"), str::to_owned);
            let light = light_of(document, light.light, world, around, &shown, remarks)?;
            lights.extend(light.map(|light| NamedLight {
                name: name.unwrap_or_default().to_owned(),
                light,
            }));
        }
        if let (Some(index), None) = (node_record.camera, camera) {
            camera = camera_of(document, index, world)?;
        }
    }
    Ok((lights, camera))
}

fn light_of(
    document: &Document,
    index: Index,
    world: &Affine,
    around: &DBounds,
    name: &str,
    remarks: &mut Remarks,
) -> Result<Option<Light>, Malformed> {
    let all = document
        .extensions
        .lights
        .as_ref()
        .map_or(&[][..], |lights| &lights.lights);
    let light = all
        .get(index as usize)
        .ok_or_else(|| beyond(List::Lights, index, all.len()))?;
    let color = Rgb::from_array(light.color.unwrap_or([1.0; 3]));
    let strength = color * light.intensity.unwrap_or(1.0);
    let is_right = strength.as_vec3().is_finite() && strength.min_element() >= 0.0;
    let direction = direction_of(world.linear * -DVec3::Z);
    let position = world.translate;
    let (true, Some(direction)) = (is_right, direction) else {
        remarks.add(name, "has no direction or strength; it is left out");
        return Ok(None);
    };
    Ok(match light.kind.as_str() {
        "point" => Some(Light::Point {
            position,
            intensity: strength,
        }),
        "spot" => {
            remarks.add(
                name,
                "is a spot; it shines on all it faces, less to its sides",
            );
            Some(Light::Disk {
                center: position,
                facing: Facing::Normal(direction),
                radius: SPOT_RADIUS,
                // Along its axis, a disk of radiance L and area A has the intensity L·A.
                radiance: strength / (std::f64::consts::PI * SPOT_RADIUS * SPOT_RADIUS),
                visible: false,
            })
        }
        "directional" => {
            remarks.add(
                name,
                "shines from far away; it is a point at 10000 times the size of all objects",
            );
            let (center, size) = if around.is_empty() {
                (DVec3::ZERO, 1.0)
            } else {
                (around.center(), around.diagonal())
            };
            let distance = FAR * size;
            // The irradiance at a distance is the intensity over its square.
            let intensity = strength * (distance * distance);
            let position = center - direction * distance;
            let is_there = intensity.as_vec3().is_finite() && position.is_finite();
            is_there.then_some(Light::Point {
                position,
                intensity,
            })
        }
        _ => {
            remarks.add(name, "is of an unknown kind; it is left out");
            None
        }
    })
}

/// A camera that looks along its −Z with +Y up; `None` where it is of a kind the scene has not, or looks nowhere.
fn camera_of(
    document: &Document,
    index: Index,
    world: &Affine,
) -> Result<Option<Camera>, Malformed> {
    let all = &document.cameras;
    let camera = all
        .get(index as usize)
        .ok_or_else(|| beyond(List::Cameras, index, all.len()))?;
    let Some(perspective) = &camera.perspective else {
        return Ok(None);
    };
    let fov = perspective.yfov.to_degrees();
    let forward = direction_of(world.linear * -DVec3::Z);
    let up = direction_of(world.linear * DVec3::Y);
    let (Some(forward), Some(up), true) = (forward, up, fov > 0.0 && fov < 180.0) else {
        return Ok(None);
    };
    let camera = Camera {
        eye: world.translate,
        target: world.translate + forward,
        up,
        vertical_fov: Degrees(fov),
        ..Camera::default()
    };
    Ok(camera.axes().is_some().then_some(camera))
}
