// An image as the background: seen behind objects and in mirrors, and lighting matt surfaces.

struct SkyImage {
    // Its axes, of which `front.w` is 1 where there is an image and `left.w` the factor to its radiance.
    front: vec4f,
    left: vec4f,
    up: vec4f,
    // What a white matt surface sends back of it, as a polynomial of second degree in the normal along the axes.
    light: array<vec4f, 9>,
}

@group(1) @binding(0) var<uniform> sky_image: SkyImage;
@group(1) @binding(1) var sky_texels: texture_2d<f32>;

fn has_image() -> bool {
    return sky_image.front.w > 0.5;
}

// A direction along the image's axes: to its centre, to its left, to its top.
fn in_image(direction: vec3f) -> vec3f {
    return vec3f(
        dot(direction, sky_image.front.xyz),
        dot(direction, sky_image.left.xyz),
        dot(direction, sky_image.up.xyz),
    );
}

// Cosine to the top at the upper edge of row `row` of cells, which lie between the texels' centres.
fn edge_cosine(row: i32, height: i32) -> f32 {
    if row <= 0 {
        return 1.0;
    }
    if row > height {
        return -1.0;
    }
    return cos(PI * (f32(row) - 0.5) / f32(height));
}

// As the renderer interpolates: linear in the azimuth and in the cosine to the top.
fn image_radiance(direction: vec3f) -> vec3f {
    let local = in_image(direction);
    let size = vec2i(textureDimensions(sky_texels));
    let x = (0.5 - atan2(local.y, local.x) / (2.0 * PI)) * f32(size.x) - 0.5;
    let column = floor(x);
    let left = (i32(column) + size.x) % size.x;
    let right = (left + 1) % size.x;
    let row = clamp(i32(acos(clamp(local.z, -1.0, 1.0)) / PI * f32(size.y) + 0.5), 0, size.y);
    let above = edge_cosine(row, size.y);
    let below = edge_cosine(row + 1, size.y);
    let y = clamp((above - local.z) / (above - below), 0.0, 1.0);
    let upper = max(row - 1, 0);
    let lower = min(row, size.y - 1);
    let high = mix(texel(left, upper), texel(right, upper), x - column);
    let low = mix(texel(left, lower), texel(right, lower), x - column);
    return mix(high, low, y) * sky_image.left.w;
}

fn texel(x: i32, y: i32) -> vec3f {
    return textureLoad(sky_texels, vec2i(x, y), 0).rgb;
}

// What a white matt surface with normal `n` sends back of the image, nothing in the way.
fn image_light(n: vec3f) -> vec3f {
    let v = in_image(n);
    let light = sky_image.light[0].rgb
        + sky_image.light[1].rgb * v.x
        + sky_image.light[2].rgb * v.y
        + sky_image.light[3].rgb * v.z
        + sky_image.light[4].rgb * (v.x * v.y)
        + sky_image.light[5].rgb * (v.y * v.z)
        + sky_image.light[6].rgb * (v.x * v.z)
        + sky_image.light[7].rgb * (3.0 * v.z * v.z - 1.0)
        + sky_image.light[8].rgb * (v.x * v.x - v.y * v.y);
    return max(light, vec3f(0.0)) * sky_image.left.w;
}
