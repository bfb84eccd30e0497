//! `raymini check SCENE` as a user calls it: what it finds in meshes and scenes whose hazards are known by construction.

use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Output};

use raymini::geometry::TriangleMesh;
use raymini::geometry::shapes::{cuboid, icosphere};
use raymini::math::DVec3;
use serde_json::{Value, json};
use tempfile::TempDir;

/// A folder to put a scene in, with a square of side 20 in z = 0 and a cube of side 1 in it.
struct Folder(TempDir);

const SETTINGS: &str = "
[camera]
eye = [3, -6, 3]
[background]
radiance = [0.5, 0.5, 0.5]
[render]
width = 16
height = 12
max_bounces = 64
";

impl Folder {
    fn new() -> Self {
        let folder = Self(TempDir::new().expect("a folder"));
        folder.write(
            "ground.off",
            "OFF\n4 1 0\n-10 -10 0\n10 -10 0\n10 10 0\n-10 10 0\n4 0 1 2 3\n",
        );
        folder.mesh("cube.off", &cube());
        folder
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path().join(name), text).expect("is written");
    }

    /// Writes a mesh, with all digits.
    fn mesh(&self, name: &str, mesh: &TriangleMesh) {
        let keyword = if mesh.normals.is_some() {
            "NOFF"
        } else {
            "OFF"
        };
        let mut text = format!(
            "{keyword}\n{} {} 0\n",
            mesh.positions.len(),
            mesh.triangles.len()
        );
        for (vertex, p) in mesh.positions.iter().enumerate() {
            write!(text, "{} {} {}", p.x, p.y, p.z).expect("is written");
            if let Some(normals) = &mesh.normals {
                let n = normals[vertex];
                write!(text, " {} {} {}", n.x, n.y, n.z).expect("is written");
            }
            text.push('\n');
        }
        for [a, b, c] in &mesh.triangles {
            writeln!(text, "3 {a} {b} {c}").expect("is written");
        }
        self.write(name, &text);
    }

    /// Runs `raymini check` on a scene of [`SETTINGS`] and `text`.
    fn run(&self, text: &str, arguments: &[&str]) -> Output {
        self.write("scene.toml", &format!("{SETTINGS}{text}"));
        Command::new(env!("CARGO_BIN_EXE_raymini"))
            .current_dir(self.path())
            .args(["check", "scene.toml"])
            .args(arguments)
            .output()
            .expect("starts")
    }

    fn succeed(&self, text: &str, arguments: &[&str]) -> String {
        let output = self.run(text, arguments);
        let complaint = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{complaint}");
        assert_eq!(complaint, "");
        String::from_utf8(output.stdout).expect("is text")
    }

    fn facts(&self, text: &str) -> Value {
        serde_json::from_str(&self.succeed(text, &["--json"])).expect("is JSON")
    }

    /// The hazards of a scene.
    fn hazards(&self, text: &str) -> Vec<Value> {
        self.facts(text)["hazards"]
            .as_array()
            .expect("a list")
            .clone()
    }

    /// The one hazard of a scene, of this kind.
    fn hazard(&self, text: &str, kind: &str) -> Value {
        let hazards = self.hazards(text);
        assert_eq!(hazards.len(), 1, "{hazards:#?}");
        assert_eq!(hazards[0]["kind"], kind, "{hazards:#?}");
        hazards[0].clone()
    }
}

fn cube() -> TriangleMesh {
    cuboid(DVec3::new(-0.5, -0.5, 1.0), DVec3::new(0.5, 0.5, 2.0))
}

/// A scene of one mesh with this material; more lines of the object go between.
fn object(mesh: &str, lines: &str, material: &str) -> String {
    format!(
        "[[objects]]\nname = \"it\"\nmesh = \"{mesh}\"\nmaterial = \"m\"\n{lines}\n[materials.m]\n{material}\n"
    )
}

const GLASS: &str = "kind = \"glass\"\nior = 1.5";
const MATT: &str = "diffuse = [0.5, 0.5, 0.5]";

fn reversed(mesh: &mut TriangleMesh, faces: impl IntoIterator<Item = usize>) {
    for face in faces {
        mesh.triangles[face].swap(1, 2);
    }
}

fn figure(hazard: &Value) -> f64 {
    hazard["figure"]["value"].as_f64().expect("a number")
}

/// A sheet has a rim, a cube is closed, a point light and a sky light them: nothing is wrong.
#[test]
fn a_clean_scene_has_no_hazard() {
    let folder = Folder::new();
    let text = "[[objects]]\nmesh = \"ground.off\"\n[[objects]]\nmesh = \"cube.off\"\n\
                [[lights]]\nposition = [2, -2, 4]\n";
    let facts = folder.facts(text);
    assert_eq!(facts["hazards"], json!([]));
    assert_eq!(facts["warnings"], json!([]));
    assert_eq!(facts["scene"], "scene.toml");
    assert!(
        facts["seconds"]
            .as_f64()
            .is_some_and(|seconds| seconds > 0.0)
    );
    let said = folder.succeed(text, &[]);
    assert!(said.starts_with("scene.toml: nothing found, in ") && said.lines().count() == 1);
}

#[test]
fn duplicates_slivers_and_dropped_faces_are_counted() {
    let folder = Folder::new();
    let mut mesh = cube();
    // Doubles: one in another order, one that turns the other way, one by vertices of its own.
    let [a, b, c] = mesh.triangles[0];
    mesh.triangles.push([b, c, a]);
    let [a, b, c] = mesh.triangles[5];
    mesh.triangles.push([a, c, b]);
    let first = u32::try_from(mesh.positions.len()).expect("few");
    mesh.positions.extend(mesh.corners(7));
    mesh.triangles.push([first, first + 1, first + 2]);
    // Slivers, closed as pillows of two sides each. Their height over their length is 4e-5 and 2e-5.
    for (x, height) in [(4.0, 4e-5), (6.0, 2e-5)] {
        let first = u32::try_from(mesh.positions.len()).expect("few");
        mesh.positions.extend([
            DVec3::new(x, 0.0, 1.0),
            DVec3::new(x + 1.0, 0.0, 1.0),
            DVec3::new(x + 0.5, height, 1.0),
        ]);
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    // No area: the loader leaves it out.
    mesh.triangles.push([first, first + 1, first]);
    folder.mesh("mesh.off", &mesh);
    let facts = folder.facts(&object("mesh.off", "", MATT));
    let of_kind = |kind: &str| {
        let mut found = facts["hazards"].as_array().expect("a list").iter();
        found
            .find(|hazard| hazard["kind"] == kind)
            .expect(kind)
            .clone()
    };
    let doubles = of_kind("duplicate_faces");
    assert_eq!(
        (&doubles["count"], &doubles["severity"]),
        (&json!(3), &json!("note"))
    );
    let faces: Vec<_> = doubles["where"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|p| p["faces"][0].as_u64())
        .collect();
    for face in [12, 13, 14] {
        assert!(faces.contains(&Some(face)), "{faces:?}");
    }
    let slivers = of_kind("slivers");
    assert_eq!(slivers["count"], 2);
    assert!((figure(&slivers) - 2e-5).abs() < 1e-12);
    assert_eq!(slivers["where"][1]["faces"], json!([16]));
    // Three edges each.
    assert_eq!(of_kind("open_edges")["count"], 6);
    let warnings = facts["warnings"].as_array().expect("a list");
    assert!(
        warnings[0]
            .as_str()
            .is_some_and(|w| w.contains("1 face without area was dropped"))
    );
}

#[test]
fn open_edges_matter_for_glass_and_copies_are_counted_once() {
    let folder = Folder::new();
    let mut mesh = cube();
    mesh.triangles.remove(3);
    folder.mesh("open.off", &mesh);
    let matt = folder.hazard(&object("open.off", "", MATT), "open_edges");
    assert_eq!(
        (&matt["count"], &matt["severity"]),
        (&json!(3), &json!("note"))
    );
    let copies = "copies = { count = [3, 2, 1], step = [3.0, 3.0, 0.0] }\ntranslate = [2, 0, 0]";
    let glass = folder.hazard(&object("open.off", copies, GLASS), "open_edges");
    assert_eq!(
        (&glass["count"], &glass["severity"]),
        (&json!(3), &json!("warning"))
    );
    assert_eq!(
        (&glass["copies"], &glass["objects"]),
        (&json!(6), &json!(["it"]))
    );
    for place in glass["where"].as_array().expect("a list") {
        let x = place["position"][0].as_f64().expect("a number");
        assert!((1.5..=2.5).contains(&x), "{x}");
    }
    // A sheet of glass is open as well.
    let sheet = folder.hazard(&object("ground.off", "", GLASS), "open_edges");
    assert_eq!(sheet["count"], 4);
}

#[test]
fn crowded_edges_are_those_with_more_than_two_faces() {
    let folder = Folder::new();
    let mut mesh = cube();
    let other = cuboid(DVec3::new(0.5, 0.5, 1.0), DVec3::new(1.5, 1.5, 2.0));
    let first = u32::try_from(mesh.positions.len()).expect("few");
    mesh.positions.extend(other.positions);
    mesh.triangles
        .extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
    folder.mesh("touching.off", &mesh);
    let hazard = folder.hazard(&object("touching.off", "", MATT), "crowded_edges");
    assert_eq!(
        (&hazard["count"], &hazard["severity"]),
        (&json!(1), &json!("note"))
    );
    assert_eq!(
        hazard["where"][0]["faces"].as_array().map(Vec::len),
        Some(4)
    );
    assert_eq!(hazard["where"][0]["position"], json!([0.5, 0.5, 1.5]));
}

#[test]
fn flipped_faces_are_found_one_by_one() {
    let folder = Folder::new();
    let mut mesh = icosphere(2);
    reversed(&mut mesh, [3, 100, 222]);
    folder.mesh("flipped.off", &mesh);
    let flat = folder.hazard(&object("flipped.off", "", MATT), "flipped_windings");
    assert_eq!(
        (&flat["count"], &flat["severity"]),
        (&json!(3), &json!("note"))
    );
    let faces: Vec<_> = flat["where"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|p| p["faces"][0].clone())
        .collect();
    assert_eq!(faces, [3, 100, 222]);
    assert!(
        flat["message"]
            .as_str()
            .is_some_and(|m| m.contains("across 9 edges"))
    );
    let smooth = folder.hazard(
        &object("flipped.off", "smooth = true", MATT),
        "flipped_windings",
    );
    assert_eq!(smooth["severity"], "warning");
}

#[test]
fn closed_surfaces_that_look_inwards_are_inside_out_unless_they_are_hollows() {
    let folder = Folder::new();
    let mut mesh = icosphere(2);
    let count = mesh.triangles.len();
    reversed(&mut mesh, 0..count);
    folder.mesh("inwards.off", &mesh);
    let hazard = folder.hazard(&object("inwards.off", "", GLASS), "inside_out");
    assert_eq!(
        (&hazard["count"], &hazard["severity"]),
        (&json!(1), &json!("warning"))
    );
    // A placement that mirrors turns faces too, and the renderer turns them back.
    assert_eq!(
        folder.hazards(&object("cube.off", "scale = -1.0", GLASS)),
        Vec::<Value>::new()
    );
    // A hollow ball.
    let first = u32::try_from(mesh.positions.len()).expect("few");
    let outer = icosphere(2);
    mesh.positions
        .extend(outer.positions.iter().map(|&p| p * 1.5));
    mesh.triangles
        .extend(outer.triangles.iter().map(|t| t.map(|v| v + first)));
    folder.mesh("hollow.off", &mesh);
    assert_eq!(
        folder.hazards(&object("hollow.off", "", GLASS)),
        Vec::<Value>::new()
    );
}

/// The first twelve vertices of the ball are those of an icosahedron, where five faces meet.
#[test]
fn normals_that_oppose_their_faces_are_counted_by_corners() {
    let folder = Folder::new();
    let mut mesh = icosphere(2);
    let mut normals = mesh.positions.clone();
    mesh.normals = Some(normals.clone());
    folder.mesh("right.off", &mesh);
    let smooth = |mesh: &str| object(mesh, "smooth = true", MATT);
    assert_eq!(folder.hazards(&smooth("right.off")), Vec::<Value>::new());
    normals[4] = -normals[4] * 100.0;
    normals[9] = DVec3::ZERO;
    mesh.normals = Some(normals);
    folder.mesh("wrong.off", &mesh);
    let hazards = folder.hazards(&smooth("wrong.off"));
    let found: Vec<_> = hazards
        .iter()
        .map(|h| (&h["kind"], &h["count"], &h["severity"]))
        .collect();
    assert_eq!(
        found,
        [
            (&json!("opposed_normals"), &json!(5), &json!("warning")),
            (&json!("zero_normals"), &json!(5), &json!("note"))
        ]
    );
}

/// A cube and a tetrahedron are the coarsest meshes whose smooth normals lean as far as those of a sphere's corners do: 54.7° and 70.5°.
#[test]
fn normals_that_lean_far_away_from_their_faces_are_told() {
    let folder = Folder::new();
    let smooth = |mesh: &str| object(mesh, "smooth = true", MATT);
    let ball = icosphere(3);
    let leaning = |degrees: f64| {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let normal = |&p: &DVec3| p * cosine + p.any_orthonormal_vector() * sine;
        let normals = ball.positions.iter().map(normal).collect();
        folder.mesh(
            "leaning.off",
            &TriangleMesh {
                normals: Some(normals),
                ..ball.clone()
            },
        );
        folder.hazards(&smooth("leaning.off"))
    };
    assert_eq!(leaning(60.0), Vec::<Value>::new());
    let hazards = leaning(82.0);
    assert_eq!(hazards.len(), 1, "{hazards:#?}");
    let found = (&hazards[0]["kind"], &hazards[0]["severity"]);
    assert_eq!(found, (&json!("leaning_normals"), &json!("warning")));
    // Corners are off the middles of their faces by some 5°.
    assert_eq!(hazards[0]["count"], 1280);

    let mut coarse = cuboid(-DVec3::ONE, DVec3::ONE);
    coarse.normals = Some(coarse.positions.clone());
    folder.mesh("coarse.off", &coarse);
    assert_eq!(folder.hazards(&smooth("coarse.off")), Vec::<Value>::new());
    let corners = [
        DVec3::new(1.0, 1.0, 1.0),
        DVec3::new(1.0, -1.0, -1.0),
        DVec3::new(-1.0, 1.0, -1.0),
        DVec3::new(-1.0, -1.0, 1.0),
    ];
    let coarse = TriangleMesh {
        positions: corners.to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]],
        normals: Some(corners.to_vec()),
        ..TriangleMesh::default()
    };
    folder.mesh("coarse.off", &coarse);
    assert_eq!(folder.hazards(&smooth("coarse.off")), Vec::<Value>::new());
}

/// The figure against rounding done here: the ground's half side of 10ˢ fixes the power of two by which all is divided.
#[test]
fn a_small_ball_far_out_in_a_large_scene_is_crushed() {
    let folder = Folder::new();
    let ball = icosphere(3);
    folder.mesh("ball.off", &ball);
    let edge = {
        let edges = ball
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        let mut lengths: Vec<f64> = edges
            .map(|(a, b)| (ball.positions[a as usize] - ball.positions[b as usize]).length())
            .collect();
        lengths.sort_by(f64::total_cmp);
        lengths[lengths.len() / 2]
    };
    for (half_side, power) in [(1e3, 10), (1e4, 14), (1e6, 20), (1e7, 24)] {
        let place = DVec3::new(half_side / 3.0, half_side / 4.0, 0.0);
        let text = format!(
            "[[objects]]\nname = \"ground\"\nmesh = \"ground.off\"\nscale = {}\ntranslate = [0, 0, -1.1]\n\
             [[objects]]\nname = \"ball\"\nmesh = \"ball.off\"\ntranslate = [{}, {}, 0]\n",
            half_side / 10.0,
            place.x,
            place.y
        );
        let hazards = folder.hazards(&text);
        let found = hazards.iter().find(|h| h["kind"] == "coarse_resolution");
        if half_side < 1e5 {
            assert!(found.is_none(), "{found:?}");
            continue;
        }
        let found = found.expect("is crushed");
        assert_eq!(
            (&found["object"], &found["severity"]),
            (&json!("ball"), &json!("warning"))
        );
        let unit = 2_f64.powi(power);
        let moved = ball.positions.iter().map(|&p| {
            let exact = (p + place) / unit;
            (exact.as_vec3().as_dvec3() - exact).length() * unit
        });
        let expected = moved.fold(0.0, f64::max) / edge;
        // The ball's height reaches beyond the ground's plane and moves the middle by a bit.
        assert!(
            (figure(found) / expected - 1.0).abs() < 0.3,
            "{} {expected}",
            figure(found)
        );
    }
}

/// Copies share triangles in a frame of their own, where nothing is lost; points on them are still rounded in the scene.
#[test]
fn copies_keep_their_shape_in_a_large_scene() {
    let folder = Folder::new();
    folder.mesh("ball.off", &icosphere(3));
    let text = "[[objects]]\nmesh = \"ground.off\"\nscale = 1e5\ntranslate = [0, 0, -1.1]\n\
                [[objects]]\nname = \"balls\"\nmesh = \"ball.off\"\ntranslate = [333333.3, 250000.2, 0]\n\
                copies = { count = [5, 1, 1], step = [3.0, 0.0, 0.0] }\n";
    let hazard = folder.hazard(text, "coarse_resolution");
    assert_eq!(
        (&hazard["object"], &hazard["severity"]),
        (&json!("balls"), &json!("note"))
    );
    // Half of 2⁻²⁵ · 2²⁰ over the edge.
    assert!(
        (figure(&hazard) / (0.5 / 32.0 / 0.154) - 1.0).abs() < 0.2,
        "{}",
        figure(&hazard)
    );
}

#[test]
fn digits_lost_before_the_file_was_written_are_told_from_those_that_are_there() {
    let folder = Folder::new();
    let far = DVec3::new(2e5, 0.0, 0.0);
    let mut mesh = icosphere(3);
    for p in &mut mesh.positions {
        *p = (*p + far).as_vec3().as_dvec3();
    }
    folder.mesh("narrow.off", &mesh);
    let hazards = folder.hazards(&object("narrow.off", "", MATT));
    let lost = hazards
        .iter()
        .find(|h| h["kind"] == "lost_digits")
        .expect("is told");
    // From 131072 to 262144, numbers are 1/64 apart.
    let edge = 0.154;
    assert!(
        (figure(lost) / (1.0 / 64.0 / edge) - 1.0).abs() < 0.2,
        "{}",
        figure(lost)
    );
    let mut mesh = icosphere(3);
    for p in &mut mesh.positions {
        *p += far;
    }
    folder.mesh("wide.off", &mesh);
    // Before the camera.
    let back = "translate = [-200000, 0, 0]";
    assert_eq!(
        folder.hazards(&object("wide.off", back, MATT)),
        Vec::<Value>::new()
    );
    // Whole numbers have all their digits.
    let mut mesh = cube();
    for p in &mut mesh.positions {
        *p = *p * 2.0 + far * 10.0;
    }
    folder.mesh("whole.off", &mesh);
    let back = "translate = [-2000000, 0, 0]";
    assert_eq!(
        folder.hazards(&object("whole.off", back, MATT)),
        Vec::<Value>::new()
    );
}

#[test]
fn materials_that_make_light_are_told_where_light_bounces() {
    let folder = Folder::new();
    let material = "diffuse = [0.8, 0.2, 0.2]\nspecular = [0.4, 0.1, 0.1]";
    let text = object("cube.off", "", material);
    assert_eq!(folder.hazards(&text), Vec::<Value>::new());
    folder.write("path.toml", &format!("{SETTINGS}mode = \"path\"\n{text}"));
    let output = Command::new(env!("CARGO_BIN_EXE_raymini"))
        .current_dir(folder.path())
        .args(["check", "path.toml", "--json"])
        .output()
        .expect("starts");
    let facts: Value = serde_json::from_slice(&output.stdout).expect("is JSON");
    let hazard = &facts["hazards"][0];
    assert_eq!(
        (&hazard["kind"], &hazard["material"]),
        (&json!("energy_creating"), &json!("m"))
    );
    assert!((figure(hazard) - 1.2).abs() < 1e-12);
}

#[test]
fn lights_that_cut_touch_or_nearly_touch_a_surface_are_told() {
    let folder = Folder::new();
    let ground = "[[objects]]\nname = \"ground\"\nmesh = \"ground.off\"\n";
    let lit = |light: &str| format!("{ground}[[lights]]\n{light}\n");
    let disk = |z: f64, normal: &str| {
        lit(&format!(
            "kind = \"disk\"\nradius = 0.5\ncenter = [1, 2, {z}]\nnormal = {normal}"
        ))
    };
    // Both triangles meet in the diagonal x = y; the disk's trace in z = 0 reaches from x = 0.5 to 1.5 at y = 2.
    let cut = folder.hazard(&disk(0.0, "[0, 1, 0]"), "light_cut");
    assert_eq!(
        (&cut["count"], &cut["light"], &cut["object"]),
        (&json!(1), &json!(0), &json!("ground"))
    );
    let near = folder.hazard(&disk(0.0001, "[0, 0, -1]"), "light_touching");
    assert_eq!(
        (&near["count"], &near["severity"]),
        (&json!(1), &json!("warning"))
    );
    assert!((figure(&near) - 0.0002).abs() < 1e-9);
    // Of a face of side 20, the place that is touched.
    for (axis, expected) in [1.0, 2.0, 0.0].into_iter().enumerate() {
        let found = near["where"][0]["position"][axis].as_f64();
        assert!((found.expect("a number") - expected).abs() < 1e-9, "{near}");
    }
    let in_plane = folder.hazard(&disk(0.0, "[0, 0, 1]"), "light_touching");
    assert_eq!(
        (&in_plane["severity"], figure(&in_plane)),
        (&json!("note"), 0.0)
    );
    // Its back is black.
    assert_eq!(
        folder.hazards(&disk(0.0001, "[0, 0, 1]")),
        Vec::<Value>::new()
    );
    assert_eq!(
        folder.hazards(&disk(0.01, "[0, 0, -1]")),
        Vec::<Value>::new()
    );
    let point = folder.hazard(&lit("position = [1, 2, 1e-5]"), "light_touching");
    assert!((figure(&point) - 1e-5).abs() < 1e-12);
    assert_eq!(
        folder.hazards(&lit("position = [1, 2, 0.01]")),
        Vec::<Value>::new()
    );
}

#[test]
fn faces_of_two_objects_in_one_place_are_coincident() {
    let folder = Folder::new();
    // The same cube, moved in its file and moved back.
    let mut moved = cube();
    for p in &mut moved.positions {
        *p += DVec3::new(0.1, -0.7, 0.3);
    }
    folder.mesh("moved.off", &moved);
    let two = |material: &str| {
        format!(
            "[[objects]]\nname = \"a\"\nmesh = \"cube.off\"\n\
             [[objects]]\nname = \"b\"\nmesh = \"moved.off\"\ntranslate = [-0.1, 0.7, -0.3]\nmaterial = \"m\"\n\
             [materials.m]\n{material}\n"
        )
    };
    let hazard = folder.hazard(&two(MATT), "coincident_faces");
    assert_eq!(
        (&hazard["count"], &hazard["severity"]),
        (&json!(12), &json!("warning"))
    );
    assert_eq!(hazard["objects"], json!(["a", "b"]));
    // Copies that do not move: the second, third and fourth coincide with the first.
    let copies = "copies = { count = [2, 2, 1], step = [0.0, 0.0, 0.0] }";
    let hazard = folder.hazard(&object("cube.off", copies, MATT), "coincident_faces");
    assert_eq!(
        (&hazard["count"], &hazard["severity"]),
        (&json!(36), &json!("note"))
    );
}

/// Two squares of side 3 that overlap in a plane, askew, which one ray meets in this order and the next in that.
#[test]
fn faces_that_overlap_in_a_plane_are_told_where_they_are_seen() {
    let folder = Folder::new();
    let square = |name: &str, [x, y]: [f64; 2], z: f64| {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let positions = corners.map(|[u, v]| DVec3::new(x + 1.5 * u, y + 1.5 * v, z));
        folder.mesh(
            name,
            &TriangleMesh {
                positions: positions.to_vec(),
                triangles: vec![[0, 1, 2], [0, 2, 3]],
                ..TriangleMesh::default()
            },
        );
    };
    square("first.off", [0.0, 0.0], 0.0);
    let two = |rotate: &str, material: &str| {
        let both = ["first", "second"].map(|name| {
            let material = if name == "second" { material } else { "m" };
            format!(
                "[[objects]]\nname = \"{name}\"\nmesh = \"{name}.off\"\nrotate = {rotate}\nmaterial = \"{material}\"\n"
            )
        });
        format!(
            "{}[materials.m]\n{MATT}\n[materials.red]\ndiffuse = [0.5, 0, 0]\n",
            both.concat()
        )
    };
    square("second.off", [0.4, 0.5], 0.0);
    for rotate in ["[31, 17, 5]", "[0, 0, 0]"] {
        let told = folder.hazard(&two(rotate, "red"), "overlapping_faces");
        assert_eq!(
            (&told["objects"], &told["severity"]),
            (&json!(["first", "second"]), &json!("warning"))
        );
        // The picture has 192 pixels.
        let count = told["count"].as_u64().expect("a number");
        assert!((4..192).contains(&count), "{count}");
        let place = &told["where"][0];
        assert_eq!(place["faces"].as_array().map(Vec::len), Some(2), "{place}");
        let alike = folder.hazard(&two(rotate, "m"), "overlapping_faces");
        assert_eq!(alike["severity"], "note");
    }
    // One above the other, and side by side.
    for (place, z) in [([0.4, 0.5], 0.01), ([3.0, 0.0], 0.0)] {
        square("second.off", place, z);
        for rotate in ["[31, 17, 5]", "[0, 0, 0]"] {
            let hazards = folder.hazards(&two(rotate, "red"));
            assert_eq!(hazards, Vec::<Value>::new(), "{place:?} {z}");
        }
    }
    // A body that stands on a floor hides where both are in one plane.
    let standing = format!(
        "[[objects]]\nmesh = \"ground.off\"\n{}",
        object("cube.off", "translate = [0, 0, -1]", MATT)
    );
    assert_eq!(folder.hazards(&standing), Vec::<Value>::new());
}

#[test]
fn nothing_overlaps_in_the_demo() {
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/demo.toml");
    let output = Command::new(env!("CARGO_BIN_EXE_raymini"))
        .args(["check", "--json"])
        .arg(demo)
        .output()
        .expect("starts");
    let facts: Value = serde_json::from_slice(&output.stdout).expect("is JSON");
    let hazards = facts["hazards"].as_array().expect("a list");
    let is_told = |hazard: &Value| hazard["kind"] == "overlapping_faces";
    assert!(!hazards.iter().any(is_told), "{hazards:#?}");
}

/// The lower half of the picture is a mirror that halves a sky of radiance 1; without it, a third of the light is missing:
/// (½ · ½) / (½ + ½ · ½).
#[test]
fn what_max_bounces_takes_away_is_measured() {
    let folder = Folder::new();
    let text = |mode: &str, max_bounces: u32| {
        format!(
            "[camera]\neye = [0, 0, 1]\ntarget = [0, 100, 1]\n[background]\nradiance = [1, 1, 1]\n\
             [materials.m]\nkind = \"mirror\"\nreflectance = [0.5, 0.5, 0.5]\n\
             [[objects]]\nmesh = \"ground.off\"\nscale = 1000.0\nmaterial = \"m\"\n\
             [render]\nwidth = 16\nheight = 12\nmode = \"{mode}\"\nmax_bounces = {max_bounces}\n"
        )
    };
    let check = |text: &str| {
        folder.write("mirror.toml", text);
        let output = Command::new(env!("CARGO_BIN_EXE_raymini"))
            .current_dir(folder.path())
            .args(["check", "mirror.toml", "--json"])
            .output()
            .expect("starts");
        let facts: Value = serde_json::from_slice(&output.stdout).expect("is JSON");
        facts["hazards"].as_array().expect("a list").clone()
    };
    for mode in ["direct", "path"] {
        let hazards = check(&text(mode, 0));
        assert_eq!(hazards.len(), 1, "{hazards:#?}");
        assert_eq!(hazards[0]["kind"], "depth_loss");
        assert!((figure(&hazards[0]) - 1.0 / 3.0).abs() < 1e-6);
        assert_eq!(check(&text(mode, 1)), Vec::<Value>::new());
    }
}

/// The hazard of the kind `depth_loss` that is found in a scene file of this text.
fn depth_loss(folder: &Folder, text: &str) -> Value {
    folder.write("deep.toml", text);
    let output = Command::new(env!("CARGO_BIN_EXE_raymini"))
        .current_dir(folder.path())
        .args(["check", "deep.toml", "--json"])
        .output()
        .expect("starts");
    let facts: Value = serde_json::from_slice(&output.stdout).expect("is JSON");
    let hazards = facts["hazards"].as_array().expect("a list");
    let found = hazards.iter().find(|hazard| hazard["kind"] == "depth_loss");
    found.expect("is told").clone()
}

/// All that is seen is a mirror, which shows nothing at 0 bounces: what chance allows is told even where no seed differs.
#[test]
fn a_picture_that_loses_all_its_light_says_how_certain_that_is() {
    let folder = Folder::new();
    let text = "[camera]\neye = [0, 0, 1]\ntarget = [0, 1, 0]\n[background]\nradiance = [1, 1, 1]\n\
                [materials.m]\nkind = \"mirror\"\n\
                [[objects]]\nmesh = \"ground.off\"\nscale = 1000.0\nmaterial = \"m\"\n\
                [render]\nwidth = 16\nheight = 12\nmode = \"path\"\nmax_bounces = 0\n";
    let told = depth_loss(&folder, text);
    assert!((figure(&told) - 1.0).abs() < 1e-12);
    // 16 seeds of 192 samples, of which none more may have had light.
    let message = told["message"].as_str().expect("text");
    assert!(message.contains("(99.9 % to 100 %)"), "{message}");
}

/// A closed room that reflects 99 % and has a lamp of this half side below its ceiling.
fn closed_room(folder: &Folder, lamp: f64, settings: &str) -> String {
    folder.mesh("room.off", &cuboid(-DVec3::ONE, DVec3::ONE));
    let corners = [[-lamp, -lamp], [lamp, -lamp], [lamp, lamp], [-lamp, lamp]];
    let square = TriangleMesh {
        positions: corners.map(|[x, y]| DVec3::new(x, y, 0.8)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..TriangleMesh::default()
    };
    folder.mesh("lamp.off", &square);
    format!(
        "[camera]\neye = [0.5, 0.3, 0.2]\ntarget = [-1, 0, 0]\nvertical_fov = 80\n\
         [materials.m]\ndiffuse = [0.99, 0.99, 0.99]\n\
         [materials.lamp]\nkind = \"emitter\"\nradiance = [100, 100, 100]\n\
         [[objects]]\nmesh = \"room.off\"\nmaterial = \"m\"\n\
         [[objects]]\nmesh = \"lamp.off\"\nmaterial = \"lamp\"\n\
         [render]\nwidth = 16\nheight = 12\nmode = \"path\"\nmax_bounces = 8\nroulette = true\n{settings}\n"
    )
}

/// Light that bounces on without end: all but the first 8 or 9 of its terms are missing, 0.989ᵏ. Of what 64 bounces bring, only 82 %
/// are.
#[test]
fn what_is_missing_is_told_of_all_light() {
    let folder = Folder::new();
    let told = depth_loss(&folder, &closed_room(&folder, 0.05, ""));
    assert!((0.86..0.96).contains(&figure(&told)), "{told}");
    let advice = told["advice"].as_str().expect("text");
    assert!(!advice.contains("to 64"), "{advice}");
}

/// A lamp that is met by chance alone, and by next to no path.
#[test]
fn what_too_few_paths_tell_is_not_given_for_certain() {
    let folder = Folder::new();
    let text = closed_room(&folder, 1e-5, "light_sampling = \"bsdf\"");
    let told = depth_loss(&folder, &text);
    assert_eq!(told["figure"], Value::Null);
    let message = told["message"].as_str().expect("text");
    assert!(
        message.contains("how much light that takes away cannot be told"),
        "{message}"
    );
}

/// A floor lit by a small square right above what is seen, which scattering finds with the probability A / (π h²).
#[test]
fn fireflies_are_as_many_as_chance_gives() {
    let folder = Folder::new();
    let side = 0.04;
    folder.write(
        "lamp.off",
        &format!("OFF\n4 1 0\n0 0 1\n0 {side} 1\n{side} {side} 1\n{side} 0 1\n4 0 1 2 3\n"),
    );
    let text = |sampling: &str| {
        format!(
            "[camera]\neye = [0, -0.5, 0.5]\ntarget = [0, 0, 0]\nvertical_fov = 2\n\
             [materials.lamp]\nkind = \"emitter\"\nradiance = [1000, 1000, 1000]\n\
             [[objects]]\nmesh = \"ground.off\"\n[[objects]]\nmesh = \"lamp.off\"\nmaterial = \"lamp\"\n\
             [render]\nwidth = 160\nheight = 120\nsamples_per_pixel = 64\nmode = \"path\"\nmax_bounces = 1\n\
             light_sampling = \"{sampling}\"\n"
        )
    };
    let check = |sampling: &str| {
        folder.write("lamp.toml", &text(sampling));
        let output = Command::new(env!("CARGO_BIN_EXE_raymini"))
            .current_dir(folder.path())
            .args(["check", "lamp.toml", "--json"])
            .output()
            .expect("starts");
        let facts: Value = serde_json::from_slice(&output.stdout).expect("is JSON");
        facts["hazards"].as_array().expect("a list").clone()
    };
    assert_eq!(check("mis"), Vec::<Value>::new());
    let hazards = check("bsdf");
    assert_eq!(hazards.len(), 1, "{hazards:#?}");
    assert_eq!(hazards[0]["kind"], "fireflies");
    let count = hazards[0]["count"].as_f64().expect("a number");
    let samples = f64::from(64 * 128 * 96);
    let expected = samples * side * side / std::f64::consts::PI;
    // Poisson; the seed is fixed. 4 σ, and two that meet in one pixel do not count.
    assert!(
        (count - expected).abs() < 4.0 * expected.sqrt() + 0.04 * expected,
        "{count} {expected}"
    );
    let share = 1.0 - (1.0 - count / samples).powi(64);
    assert!((figure(&hazards[0]) / share - 1.0).abs() < 1e-9);
}

#[test]
fn lines_say_what_is_found_where_and_what_to_do() {
    let folder = Folder::new();
    let mut mesh = cube();
    mesh.triangles.remove(3);
    folder.mesh("open.off", &mesh);
    let said = folder.succeed(&object("open.off", "", GLASS), &[]);
    let lines: Vec<_> = said.lines().collect();
    assert!(lines[0].starts_with("scene.toml: 1 warning, in "), "{said}");
    assert_eq!(
        lines[1],
        "warning: open.off (object \"it\"): 3 edges belong to one face only: the surface is open there"
    );
    assert!(
        lines[2].starts_with("    at face ") && !lines[2].contains("more"),
        "{said}"
    );
    assert!(lines[3].starts_with("    Close the mesh: "), "{said}");
    assert_eq!(lines.len(), 4, "{said}");
}

#[test]
fn scenes_that_cannot_be_examined_are_errors() {
    let folder = Folder::new();
    let complaint = |text: &str| {
        let output = folder.run(text, &[]);
        assert_eq!(output.status.code(), Some(1));
        assert!(output.stdout.is_empty());
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert!(complaint("[[objects]]\nmesh = \"none.off\"\n").contains("there is no such file"));
    let said = complaint("[[objects]]\nmesh = \"cube.off\"\nmaterial = \"jade\"\n");
    assert!(said.contains("material \"jade\" is not defined"), "{said}");
    let said = complaint("[[objects]]\nmesh = \"cube.off\"\nscale = 1e120\n");
    assert!(said.contains("expected between"), "{said}");
    let output = Command::new(env!("CARGO_BIN_EXE_raymini"))
        .current_dir(folder.path())
        .args(["check", "nowhere.toml"])
        .output()
        .expect("starts");
    assert_eq!(output.status.code(), Some(1));
}

#[test]
fn a_picture_without_light_is_found() {
    let folder = Folder::new();
    let ground = "[[objects]]\nmesh = \"ground.off\"\n";
    let dark = SETTINGS.replace("[0.5, 0.5, 0.5]", "[0, 0, 0]");
    folder.write("dark.toml", &format!("{dark}{ground}"));
    let output = Command::new(env!("CARGO_BIN_EXE_raymini"))
        .current_dir(folder.path())
        .args(["check", "dark.toml"])
        .output()
        .expect("starts");
    let text = String::from_utf8_lossy(&output.stdout);
    let expected = "warning: the picture is black: no light and no object shines, and the background is black\n    Add a light";
    assert!(text.contains(expected), "{text}");
    assert_eq!(folder.hazards(ground), [] as [Value; 0]);
}

/// The cube stands over the middle, from 1 to 2; its faces look outwards.
#[test]
fn a_camera_that_sees_nothing_or_only_the_inside_of_a_body_is_found() {
    let folder = Folder::new();
    let check = |eye: &str, target: &str| {
        let scene = format!(
            "[camera]\neye = {eye}\ntarget = {target}\n[render]\nwidth = 16\nheight = 12\n[[objects]]\nname = \"block\"\n\
             mesh = \"cube.off\"\n[[lights]]\nposition = [2, -2, 4]\n"
        );
        folder.write("view.toml", &scene);
        let output = Command::new(env!("CARGO_BIN_EXE_raymini"))
            .current_dir(folder.path())
            .args(["check", "view.toml"])
            .output()
            .expect("starts");
        String::from_utf8(output.stdout).expect("is text")
    };
    let away = check("[0, -5, 1.5]", "[0, -9, 1.5]");
    let expected = "warning: no object is in the picture: none of 192 rays from the eye meets one\n    \
                    Aim the camera at the objects, whose middle is at (0.000, 0.000, 1.500)";
    assert!(away.contains(expected), "{away}");
    assert!(away.starts_with("view.toml: 1 warning, in "), "{away}");

    let inside = check("[0.1, 0, 1.5]", "[0.4, 0.1, 1.5]");
    let expected = "a pilot picture tell: the camera is inside of the object \"block\"\n    Move the camera out of it.";
    assert!(inside.contains(expected), "{inside}");
    assert!(inside.starts_with("view.toml: 1 warning, in "), "{inside}");

    let right = check("[0, -5, 1.5]", "[0, 0, 1.5]");
    assert!(right.starts_with("view.toml: nothing found"), "{right}");
}

/// Paths meet disks; nothing meets a point, or a disk that is not to be seen.
#[test]
fn lights_that_no_path_through_glass_or_by_mirrors_meets_are_found() {
    let folder = Folder::new();
    let point = "[[lights]]\nposition = [0, 0, 5]\n";
    let disk = "[[lights]]\nkind = \"disk\"\ncenter = [3, 0, 5]\n";
    let hidden = format!("{disk}visible = false\n");
    let scene = |mode: &str, kind: &str, lights: &str| {
        let ground = "[[objects]]\nmesh = \"ground.off\"\nmaterial = \"m\"\n";
        let text = format!(
            "mode = \"{mode}\"\n{ground}translate = [0, 0, 2]\n[materials.m]\nkind = \"{kind}\"\n{lights}"
        );
        let found = folder.hazards(&text).into_iter();
        let unmet: Vec<_> = found
            .filter(|hazard| hazard["kind"] == "unmet_lights")
            .collect();
        assert!(unmet.len() <= 1, "{unmet:#?}");
        unmet.into_iter().next()
    };
    let glass = scene("path", "glass", &format!("{disk}{point}{hidden}")).expect("is found");
    assert_eq!(
        (&glass["severity"], &glass["count"]),
        (&json!("warning"), &json!(2))
    );
    assert_eq!(
        glass["message"],
        "lights 1, 2 are points or invisible: in mode path no path meets them, so that nothing is lit by them through glass"
    );
    let mirror = scene("path", "mirror", point).expect("is found");
    assert_eq!(mirror["severity"], "note");
    assert_eq!(
        mirror["message"],
        "light 0 is a point or invisible: in mode path no path meets it, so that nothing is lit by it by mirrors"
    );
    for (mode, kind, lights) in [
        ("direct", "glass", point),
        ("path", "phong", point),
        ("path", "glass", disk),
        ("path", "glass", &format!("{point}intensity = [0, 0, 0]\n")),
        ("path", "glass", ""),
    ] {
        assert_eq!(scene(mode, kind, lights), None, "{mode} {kind} {lights}");
    }
}
