use super::*;
use crate::geometry::shapes::Random;
use crate::math::DVec3;

fn built(luminaries: &[Luminary]) -> LightTree {
    LightTree::build(luminaries, &CancelToken::new()).expect("nobody cancels")
}

fn flat(center: DVec3, reach: f64, shines: Shines, intensity: f64) -> Luminary {
    let (center, reach) = (center.as_vec3(), DVec3::splat(reach).as_vec3());
    Luminary {
        bounds: Bounds {
            min: center - reach,
            max: center + reach,
        },
        shines,
        intensity,
    }
}

/// Points, flat lights with one side and with two, in clusters of all sizes; intensities as `intensity` gives them.
fn luminaries(count: usize, mut intensity: impl FnMut(&mut Random) -> f64) -> Vec<Luminary> {
    let mut random = Random::new(31);
    let mut middle = DVec3::ZERO;
    (0..count)
        .map(|index| {
            if index % 40 == 0 {
                middle = random.in_cube();
            }
            let center = middle + random.in_cube() * random.unit().powi(4);
            let normal = random.in_cube().normalize().as_vec3();
            let intensity = intensity(&mut random);
            match index % 3 {
                0 => flat(center, 0.0, Shines::Everywhere, intensity),
                1 => flat(center, 0.02, Shines::OneSide(normal), intensity),
                _ => flat(center, 1e-4, Shines::BothSides(normal), intensity),
            }
        })
        .collect()
}

fn receiver(random: &mut Random) -> Receiver {
    Receiver {
        position: random.in_cube().as_vec3(),
        normal: random.in_cube().normalize().as_vec3(),
    }
}

fn unit_square(random: &mut Random) -> Vec2 {
    // As samplers give them: 24 bits each.
    let mut unit = || (random.bits() >> 40) as f32 / 16_777_216.0;
    Vec2::new(unit(), unit())
}

/// χ² of 200,000 choices at each of ten points, cells of fewer than 5 pooled. α = 0.001 over ten tests: with 40 degrees of
/// freedom or more, χ² is then at most 4.4 of its standard deviations above its mean.
#[test]
fn lights_are_chosen_as_often_as_stated() {
    let luminaries = luminaries(500, Random::unit);
    let tree = built(&luminaries);
    let mut random = Random::new(77);
    for _ in 0..10 {
        let at = receiver(&mut random);
        let stated: Vec<f32> = (0..500).map(|item| tree.probability(item, &at)).collect();
        let mut counts = vec![0_u32; 501];
        let draws = 200_000;
        for _ in 0..draws {
            let choice = tree.choose(&at, unit_square(&mut random));
            if let Some((item, probability)) = choice {
                assert_eq!(probability.to_bits(), stated[item].to_bits());
            }
            counts[choice.map_or(500, |(item, _)| item)] += 1;
        }
        // Ways that lead nowhere take the rest.
        let sum: f64 = stated.iter().copied().map(f64::from).sum();
        assert!(sum <= 1.0 + 1e-5, "{sum}");
        let expected = stated.iter().map(|&p| f64::from(p)).chain([1.0 - sum]);
        let (mut chi_squared, mut cells) = (0.0, 0.0);
        let (mut pooled, mut pooled_count) = (0.0, 0.0);
        for (probability, &count) in expected.zip(&counts) {
            let expected = probability * f64::from(draws);
            if expected < 5.0 {
                pooled += expected;
                pooled_count += f64::from(count);
            } else {
                chi_squared += (f64::from(count) - expected).powi(2) / expected;
                cells += 1.0;
            }
        }
        if pooled >= 5.0 {
            chi_squared += (pooled_count - pooled).powi(2) / pooled;
            cells += 1.0;
        }
        assert!(cells > 40.0, "{cells} cells");
        let degrees = cells - 1.0_f64;
        let z = (chi_squared - degrees) / (2.0 * degrees).sqrt();
        assert!(z < 4.4, "{chi_squared} of {degrees}, z = {z}");
    }
}

#[test]
fn draws_together_choose_what_each_does_alone() {
    let tree = built(&luminaries(500, Random::unit));
    let mut random = Random::new(23);
    for count in [1, 8, 64, 65, 200] {
        let at = receiver(&mut random);
        let numbers: Vec<Vec2> = (0..count).map(|_| unit_square(&mut random)).collect();
        let mut together = vec![None; numbers.len()];
        tree.choose_each(&at, numbers.iter().copied(), |index, item, probability| {
            together[index as usize] = Some((item, probability));
        });
        let alone: Vec<_> = numbers.iter().map(|&u| tree.choose(&at, u)).collect();
        assert_eq!(together, alone);
    }
}

/// In front of a surface that all lights reach, with strengths over 200 powers of two, lights at one place, and the surface
/// inside boxes of the tree.
#[test]
fn probabilities_sum_to_one_and_are_finite() {
    let mut powers = luminaries(3000, |random| (200.0 * random.unit() - 100.0).exp2());
    let (same, near) = (powers[0], powers[3]);
    powers.extend([same; 300]);
    powers.extend(
        [Luminary {
            shines: Shines::Everywhere,
            ..near
        }; 300],
    );
    // Points alone, over the floor that most of them are above.
    let mut over_floor = powers.clone();
    for luminary in &mut over_floor {
        luminary.shines = Shines::Everywhere;
        luminary.bounds.min.z = luminary.bounds.min.z.abs() + 0.01;
        luminary.bounds.max.z = luminary.bounds.min.z;
    }
    let mut random = Random::new(5);
    for (lights, all_count) in [(&powers, false), (&over_floor, true)] {
        let tree = built(lights);
        for turn in 0..30_usize {
            let mut at = receiver(&mut random);
            if turn % 3 == 0 {
                at.position = lights[turn].bounds.center();
            }
            if all_count {
                at.position.z = 0.0;
                at.normal = Vec3::Z;
            }
            let probabilities = (0..lights.len()).map(|item| tree.probability(item, &at));
            let sum: f64 = probabilities.map(f64::from).sum();
            assert!(sum.is_finite() && sum < 1.0 + 1e-5, "{sum}");
            assert!(!all_count || sum > 1.0 - 1e-5, "{sum}");
            let chosen = tree.choose(&at, unit_square(&mut random));
            assert!(!all_count || chosen.is_some());
        }
    }
}

/// What a point of a light gives, taken at its middle or anywhere in its box, decides: where that is more than nothing, the
/// probability is too, in any cluster.
#[test]
fn only_lights_that_give_nothing_are_never_chosen() {
    let luminaries = luminaries(400, |_| 1.0);
    let tree = built(&luminaries);
    let mut random = Random::new(13);
    let (mut dark, mut never) = (0, 0);
    for turn in 0..1000_usize {
        let mut at = receiver(&mut random);
        if turn % 2 == 0 {
            // Close by, also inside boxes.
            let bounds = luminaries[turn % 400].bounds;
            at.position = bounds.center() + random.in_cube().as_vec3() * 0.03;
        }
        for (item, luminary) in luminaries.iter().enumerate() {
            let share = random.in_cube().as_vec3() * 0.5 + 0.5;
            let place = luminary.bounds.min + share * luminary.bounds.size();
            let towards = place - at.position;
            let emitted = match luminary.shines {
                Shines::Everywhere => 1.0,
                Shines::OneSide(normal) => -normal.dot(towards),
                Shines::BothSides(normal) => normal.dot(towards).abs(),
            };
            let gives = at.normal.dot(towards) > 0.0 && emitted > 0.0;
            let probability = tree.probability(item, &at);
            assert!(!gives || probability > 0.0, "{at:?}, {luminary:?}");
            dark += u32::from(!gives);
            never += u32::from(probability == 0.0);
        }
    }
    // Most that give nothing are known to.
    assert!(never * 10 > dark * 8, "{never} of {dark}");
}

#[test]
fn near_lights_are_chosen_more_often_than_their_share_of_the_power() {
    let row: Vec<_> = (0..1000)
        .map(|i| flat(DVec3::X * f64::from(i), 0.0, Shines::Everywhere, 1.0))
        .collect();
    let tree = built(&row);
    let at = Receiver {
        position: Vec3::new(500.0, 0.0, -1.0),
        normal: Vec3::Z,
    };
    // 1/d² and a cosine of 1/d: 1 of the sum of all, 1 + 2 Σ (1 + k²)^(−3/2) = 2.04.
    let probability = tree.probability(500, &at);
    assert!(probability > 0.2, "{probability}");
}

#[test]
fn what_does_not_shine_is_not_in_the_tree() {
    let mut lights = luminaries(60, |_| 1.0);
    for light in &mut lights[10..] {
        light.intensity = 0.0;
    }
    let tree = built(&lights);
    assert_eq!(tree.nodes.len(), 19);
    let at = receiver(&mut Random::new(1));
    assert!((10..60).all(|item| tree.probability(item, &at) == 0.0));
    assert!(built(&lights[10..]).is_empty());
    assert!(built(&[]).choose(&at, Vec2::ZERO).is_none());
}

/// Very many lights at one place, and as many on a line at distances that double.
#[test]
fn no_arrangement_of_lights_makes_a_deep_tree() {
    let point = |x: f32| Luminary {
        bounds: Bounds::of_points([Vec3::X * x]),
        shines: Shines::Everywhere,
        intensity: 1.0,
    };
    let one_place = vec![point(0.5); 1 << 17];
    let doubling: Vec<_> = (0..1 << 17)
        .map(|i| point((f32::from(i16::try_from(i % 240).expect("small")) - 120.0).exp2()))
        .collect();
    for lights in [one_place, doubling] {
        let tree = built(&lights);
        assert_eq!(tree.nodes.len(), 2 * lights.len() - 1);
        let deepest = tree.trails.iter().map(|trail| 63 - trail.leading_zeros());
        assert!(deepest.max() < Some(HALVED_FROM + 18));
    }
}

#[test]
fn no_tree_is_built_when_cancelled() {
    let cancel = CancelToken::new();
    cancel.cancel();
    assert!(LightTree::build(&luminaries(100, Random::unit), &cancel).is_none());
}
