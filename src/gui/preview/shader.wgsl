// The preview's shading: direct light without shadows, in the units of the prepared scene.
//
// Positions are taken relative to the eye before anything is multiplied, and the eye comes in two parts, so that a vertex
// close to the eye keeps all its digits; so does the place of a copy. Images as background are in `sky.wgsl`, compiled with this
// file. Two passes share the vertex stage: colour for the screen, and object ids. Objects over which an image or the colours of
// vertices vary have entry points of their own, as have those with an image of normals; the others know nothing of textures.

const MAX_LIGHTS: u32 = 256u;

const MODE_DIRECT: u32 = 0u;
const MODE_NORMALS: u32 = 1u;
const MODE_DEPTH: u32 = 2u;
const MODE_ALBEDO: u32 = 3u;
const MODE_FACING: u32 = 4u;
const MODE_OBJECT: u32 = 5u;
const MODE_AO: u32 = 6u;

const KIND_MIRROR: u32 = 1u;
const KIND_GLASS: u32 = 2u;
const KIND_EMITTER: u32 = 3u;

// Bits of `Object.about.w`: it was moved, an image lies on it, its vertices have colours, an image says its normals.
const MOVED: u32 = 1u;
const IMAGE: u32 = 2u;
const COLORS: u32 = 4u;
const NORMALS: u32 = 8u;

const TONE_ACES: u32 = 1u;
const PHONG_CLASSIC: u32 = 1u;

const PI: f32 = 3.14159265;

struct Light {
    // Relative to the eye.
    position: vec4f,
    // Already scaled to squared prepared units.
    intensity: vec4f,
    // Where a flat light faces; `w`: 1 for a flat light, 0 for one that shines everywhere.
    normal: vec4f,
}

struct View {
    // The camera's axes, divided by the picture's half extent at distance 1. `right.w`: distance of the near plane.
    right: vec4f,
    up: vec4f,
    // `forward.w`: world units per prepared unit.
    forward: vec4f,
    eye_high: vec4f,
    eye_low: vec4f,
    // The axes times the half extent; `ray_right.w`: factor of the exposure, `ray_up.w`: one over gamma.
    ray_right: vec4f,
    ray_up: vec4f,
    // `zenith.w`: 1 where highlights mirror the background too, as in paths.
    zenith: vec4f,
    horizon: vec4f,
    ground: vec4f,
    sky_up: vec4f,
    // Mode, tone curve, Phong model, number of lights.
    choices: vec4u,
    // What of the focus is shown (0 nothing, 1 its plane, 2 the blur too); diameter of the blur in pixels per difference of reciprocal
    // distances; reciprocal of the focus distance.
    focus: vec4f,
    lights: array<Light, MAX_LIGHTS>,
}

struct Object {
    diffuse: vec4f,
    // `w`: shininess.
    specular: vec4f,
    // `w`: what shortens turned directions to the length they had.
    id_color: vec4f,
    // Index of the object, kind of its material, 1 where its copies are mirrored, what there is beside one colour at one place.
    about: vec4u,
    // From the directions of its triangles to those of the prepared scene.
    turn: mat3x3f,
    // Where it was moved: what turns places relative to the eye, and what is added to them.
    moved: mat3x3f,
    shift: vec4f,
}

@group(0) @binding(0) var<uniform> view: View;
@group(2) @binding(0) var<uniform> object: Object;
@group(3) @binding(0) var image: texture_2d<f32>;
@group(3) @binding(1) var image_sampler: sampler;
@group(3) @binding(2) var normal_image: texture_2d<f32>;

struct VertexInput {
    @location(0) position: vec3f,
    @location(1) normal: vec4f,
    // Of the copy, in two parts.
    @location(2) place_high: vec3f,
    @location(3) place_low: vec3f,
}

struct Fragment {
    @builtin(position) clip: vec4f,
    // Relative to the eye.
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
}

// Where a corner is, and its normal.
fn placed(in: VertexInput) -> Fragment {
    let turned = object.turn * in.position;
    var position = ((in.place_high - view.eye_high.xyz) + turned) + (in.place_low - view.eye_low.xyz);
    var normal = (object.turn * in.normal.xyz) * object.id_color.w;
    if (object.about.w & MOVED) != 0u {
        position = object.moved * position + object.shift.xyz;
        normal = normalize(object.moved * normal);
    }
    var out: Fragment;
    // Reverse depth without a far plane: near / distance.
    out.clip = vec4f(
        dot(position, view.right.xyz),
        dot(position, view.up.xyz),
        view.right.w,
        dot(position, view.forward.xyz),
    );
    out.position = position;
    out.normal = normal;
    return out;
}

@vertex
fn vertex(in: VertexInput) -> Fragment {
    return placed(in);
}

struct PaintedFragment {
    @builtin(position) clip: vec4f,
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) on_image: vec2f,
    @location(3) color: vec3f,
}

@vertex
fn painted_vertex(in: VertexInput, @location(4) on_image: vec2f, @location(5) color: vec4f) -> PaintedFragment {
    let plain = placed(in);
    return PaintedFragment(plain.clip, plain.position, plain.normal, on_image, color.rgb);
}

// Radiance of the background in a unit direction.
fn background(direction: vec3f) -> vec3f {
    if has_image() {
        return image_radiance(direction);
    }
    let t = dot(direction, view.sky_up.xyz);
    return mix(view.horizon.rgb, select(view.ground.rgb, view.zenith.rgb, t >= 0.0), abs(t));
}

// Mean of max(0, ω · axis) over the hemisphere of `n`, weighted by cosine, with c = n · axis:
// 2/(3π) · (sin γ + (π − γ) cos γ). This is the background's gradient seen by a matt surface, in closed form.
fn mean_towards(c: f32) -> f32 {
    let angle = acos(clamp(c, -1.0, 1.0));
    return 2.0 / (3.0 * PI) * (sin(angle) + (PI - angle) * c);
}

// What a white matt surface with normal `n` sends back of the background, nothing in the way.
fn background_light(n: vec3f) -> vec3f {
    if has_image() {
        return image_light(n);
    }
    let c = dot(n, view.sky_up.xyz);
    return view.horizon.rgb
        + (view.zenith.rgb - view.horizon.rgb) * mean_towards(c)
        + (view.ground.rgb - view.horizon.rgb) * mean_towards(-c);
}

// About what a highlight that sharp shows of the background around a unit direction: between all of a hemisphere and one point.
fn background_blurred(direction: vec3f, shininess: f32) -> vec3f {
    let sharpness = shininess / (shininess + 30.0);
    return mix(background_light(direction), background(direction), sharpness);
}

// The shading normal `n`, tilted as far as needed for `wo` to be reflected away from the surface, as the renderer does.
fn reflecting_outwards(n: vec3f, geometric: vec3f, wo: vec3f) -> vec3f {
    let least = min(0.9 * dot(geometric, wo), 0.01);
    let mirrored = reflect(-wo, n);
    let height = dot(geometric, mirrored);
    if height >= least {
        return n;
    }
    return normalize(wo + normalize(mirrored + geometric * (least - height)));
}

// All lights, without shadows. `n`, `geometric`: shading and geometric normal on the side of `wo`, the unit vector to the
// eye; `diffuse`: what is reflected in all directions.
fn direct(in: Fragment, n: vec3f, geometric: vec3f, wo: vec3f, diffuse: vec3f) -> vec3f {
    let shininess = object.specular.w;
    let mirrored = reflect(-wo, reflecting_outwards(n, geometric, wo));
    var radiance = background_light(n) * diffuse;
    if view.zenith.w > 0.5 {
        radiance += object.specular.rgb * background_blurred(mirrored, shininess);
    }
    for (var i = 0u; i < min(view.choices.w, MAX_LIGHTS); i++) {
        let to_light = view.lights[i].position.xyz - in.position;
        let squared = dot(to_light, to_light);
        let wi = to_light * inverseSqrt(squared);
        let cosine = dot(n, wi);
        if cosine <= 0.0 || squared <= 0.0 {
            continue;
        }
        let lobe = pow(max(dot(mirrored, wi), 0.0), shininess);
        var scattered: vec3f;
        if view.choices.z == PHONG_CLASSIC {
            scattered = diffuse * cosine + object.specular.rgb * lobe;
        } else {
            let peak = (shininess + 2.0) / (2.0 * PI);
            scattered = (diffuse / PI + object.specular.rgb * (peak * lobe)) * cosine;
        }
        let normal = view.lights[i].normal;
        let turned = select(1.0, max(dot(normal.xyz, -wi), 0.0), normal.w > 0.5);
        radiance += view.lights[i].intensity.rgb * turned / squared * scattered;
    }
    return radiance;
}

// Mirrors and glass show the background alone; only the picture follows rays further.
fn smooth_surface(n: vec3f, wo: vec3f) -> vec3f {
    let mirrored = background(reflect(-wo, n));
    if object.about.y == KIND_MIRROR {
        return object.diffuse.rgb * mirrored;
    }
    // Schlick's approximation is good enough to look through.
    let ior = object.specular.w;
    let facing = pow((ior - 1.0) / (ior + 1.0), 2.0);
    let cosine = abs(dot(n, wo));
    let reflectance = facing + (1.0 - facing) * pow(1.0 - cosine, 5.0);
    // Darker where the eye looks along the surface, so that a shape is seen before an even sky.
    let seen_through = background(refract(-wo, n, 1.0 / ior)) * object.diffuse.rgb * (0.4 + 0.5 * cosine);
    return mix(seen_through, mirrored, reflectance);
}

// The fit of Narkowicz (2015) to the ACES reference rendering.
fn aces(x: vec3f) -> vec3f {
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
}

// From radiance to the sRGB values of the screen.
fn displayed(radiance: vec3f) -> vec4f {
    var x = radiance * view.ray_right.w;
    if view.choices.y == TONE_ACES {
        x = aces(x);
    }
    x = pow(clamp(x, vec3f(0.0), vec3f(1.0)), vec3f(view.ray_up.w));
    let encoded = select(1.055 * pow(x, vec3f(1.0 / 2.4)) - 0.055, 12.92 * x, x <= vec3f(0.0031308));
    return vec4f(encoded, 1.0);
}

const BEFORE_FOCUS: vec3f = vec3f(0.96, 0.58, 0.16);
const BEHIND_FOCUS: vec3f = vec3f(0.22, 0.5, 0.98);
const FOCUS_PLANE: vec3f = vec3f(0.72, 1.0, 0.36);

// A color of the screen with how much the lens blurs what is there, and where the plane of focus cuts it. `nearness`: reciprocal
// distance less that of the plane; `width`: its change to the next pixel.
fn with_focus(color: vec4f, nearness: f32, width: f32) -> vec4f {
    var shown = color.rgb;
    if view.focus.x > 1.5 {
        // Up to a pixel is sharp; 64 are as good as any more.
        let blur = log2(max(view.focus.y * abs(nearness), 1.0)) / 6.0;
        let tint = select(BEHIND_FOCUS, BEFORE_FOCUS, nearness > 0.0);
        shown = mix(shown, tint, min(blur, 1.0) * 0.75);
    }
    let from_plane = abs(nearness) / (width + 1e-7 * view.focus.z);
    let line = (1.0 - smoothstep(0.8, 1.8, from_plane)) * step(1e-20, width);
    return vec4f(mix(shown, FOCUS_PLANE, line), color.a);
}

@fragment
fn color(in: Fragment, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    return focused(in, shaded(in, front, object.diffuse.rgb, sides(in)));
}

// The same where an image or the colours of vertices vary over the object.
@fragment
fn painted_color(in: PaintedFragment, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let plain = Fragment(in.clip, in.position, in.normal);
    return focused(plain, shaded(plain, front, painted_diffuse(in), sides(plain)));
}

// The same where an image says the normals too.
@fragment
fn embossed_color(in: PaintedFragment, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    let plain = Fragment(in.clip, in.position, in.normal);
    let relative = textureSample(normal_image, image_sampler, in.on_image).xyz;
    // Rows of an image begin at its top, the second coordinate at the bottom.
    let across = dpdx(in.position);
    let down = dpdy(in.position);
    let on_across = dpdx(in.on_image) * vec2f(1.0, -1.0);
    let on_down = dpdy(in.on_image) * vec2f(1.0, -1.0);
    var s = sides(plain);
    if (object.about.w & NORMALS) != 0u {
        // The directions in which the first and the second coordinate grow alone.
        let turned = sign(on_across.x * on_down.y - on_across.y * on_down.x);
        let first = (across * on_down.y - down * on_across.y) * turned;
        let second = (down * on_across.x - across * on_down.x) * turned;
        s.normal = embossed(s, is_outside(front), relative, first, second);
    }
    return focused(plain, shaded(plain, front, painted_diffuse(in), s));
}

// What a matt surface reflects in all directions where images or colours of vertices vary over it.
fn painted_diffuse(in: PaintedFragment) -> vec3f {
    var diffuse = object.diffuse.rgb;
    let texel = textureSample(image, image_sampler, in.on_image).rgb;
    if (object.about.w & IMAGE) != 0u {
        diffuse *= texel;
    }
    if (object.about.w & COLORS) != 0u {
        diffuse *= in.color;
    }
    return diffuse;
}

// The normal that an image says, `relative` to the axes in which its coordinates grow and to the normal of the outside, as the renderer
// turns it.
fn embossed(s: Sides, outside: bool, relative: vec3f, first: vec3f, second: vec3f) -> vec3f {
    let side = select(-1.0, 1.0, outside);
    let outward = s.normal * side;
    let long = first - outward * dot(outward, first);
    let squared = dot(long, long);
    // Below the smallest normal number a square has lost its digits, and with them the direction.
    if all(relative.xy == vec2f(0.0)) || squared <= 1.2e-38 {
        return s.normal;
    }
    let tangent = long * inverseSqrt(squared);
    let across = cross(outward, tangent);
    // Mirrored images turn the other way.
    let other = across * select(-1.0, 1.0, dot(across, second) >= 0.0);
    let turned = (tangent * relative.x + other * relative.y + outward * relative.z) * side;
    if dot(turned, s.geometric) <= 0.0 {
        return s.normal;
    }
    return normalize(turned);
}

// What is shown of a point, with what is to be seen of the focus.
fn focused(in: Fragment, shown: vec4f) -> vec4f {
    let nearness = 1.0 / max(dot(in.position, view.forward.xyz), 1e-18) - view.focus.z;
    let width = fwidth(nearness);
    if view.focus.x < 0.5 {
        return shown;
    }
    return with_focus(shown, nearness, width);
}

// Unit vectors: to the eye, and the normals of shape and shading on its side.
struct Sides {
    wo: vec3f,
    geometric: vec3f,
    normal: vec3f,
}

fn sides(in: Fragment) -> Sides {
    let wo = normalize(-in.position);
    let across = normalize(cross(dpdx(in.position), dpdy(in.position)));
    let geometric = select(-across, across, dot(across, wo) >= 0.0);
    let interpolated = normalize(in.normal);
    let n = select(-interpolated, interpolated, dot(interpolated, geometric) >= 0.0);
    return Sides(wo, geometric, n);
}

// Whether the outside is seen; `front`: whether corners turn counter-clockwise.
fn is_outside(front: bool) -> bool {
    return front != (object.about.z == 1u);
}

// `diffuse`: what a matt surface reflects in all directions.
fn shaded(in: Fragment, front: bool, diffuse: vec3f, s: Sides) -> vec4f {
    let wo = s.wo;
    let geometric = s.geometric;
    let n = s.normal;
    switch view.choices.x {
        case MODE_NORMALS: {
            return displayed(n * 0.5 + 0.5);
        }
        case MODE_DEPTH: {
            return displayed(vec3f(length(in.position) * view.forward.w));
        }
        case MODE_ALBEDO: {
            return displayed(diffuse + object.specular.rgb);
        }
        case MODE_FACING: {
            let cosine = abs(dot(n, wo));
            let outside = vec3f(0.0, cosine, 0.0);
            return displayed(select(vec3f(cosine, 0.0, 0.0), outside, is_outside(front)));
        }
        case MODE_OBJECT: {
            return displayed(object.id_color.rgb);
        }
        case MODE_AO: {
            // Occlusion needs rays; the preview shows the shape in a light from the eye.
            return displayed(vec3f(0.35 + 0.65 * abs(dot(n, wo))));
        }
        default: {
            if object.about.y == KIND_EMITTER {
                return displayed(object.diffuse.rgb);
            }
            if object.about.y != 0u {
                return displayed(smooth_surface(reflecting_outwards(n, geometric, wo), wo));
            }
            return displayed(direct(in, n, geometric, wo, diffuse));
        }
    }
}

// Object ids for tests and picking: 0 where nothing is, else the object's index + 1.
@fragment
fn object_id() -> @location(0) u32 {
    return object.about.x + 1u;
}

struct Sky {
    @builtin(position) clip: vec4f,
    @location(0) direction: vec3f,
}

// One triangle over the whole picture, infinitely far away.
@vertex
fn sky_vertex(@builtin(vertex_index) index: u32) -> Sky {
    let corner = vec2f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0);
    var out: Sky;
    out.clip = vec4f(corner, 0.0, 1.0);
    out.direction = view.forward.xyz + view.ray_right.xyz * corner.x + view.ray_up.xyz * corner.y;
    return out;
}

@fragment
fn sky_color(in: Sky) -> @location(0) vec4f {
    if view.choices.x != MODE_DIRECT {
        return displayed(vec3f(0.0));
    }
    return displayed(background(normalize(in.direction)));
}
