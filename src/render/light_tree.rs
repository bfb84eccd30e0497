//! Choosing one of very many lights by what each may give a surface point.
//!
//! A binary tree over everything that shines. Each node bounds what is below it: the places by a box, the normals by a cone,
//! the strength by the sum of the intensities. A choice starts at the root and takes one of the two children by what they may
//! give the point at hand, so it costs a step per level, and near lights in front of the surface that shine its way are
//! chosen far more often than others. The probability of any light follows from the same steps.
//!
//! A light has probability 0 only where it can give nothing: all of it behind the surface, or all of it facing away. So
//! dividing by the probability is unbiased. Occlusion, colours and the sharpness of the surface are not looked at.
//!
//! Sources: Conty Estevez & Kulla, Importance Sampling of Many Lights with Adaptive Tree Splitting, 2018 (without their
//! splitting); the bounds of a node in the form of Pharr et al., Physically Based Rendering (4th ed.), section on BVH light
//! sampling.

use crate::math::{Bounds, DVec3, Vec2, Vec3};

/// Cosines nearer to 0 than this, about a quarter of a degree from edge-on, count as this. It is far more than the rounding,
/// in `f32`, of what lights are then found to give, so that nothing is taken to be dark that is not, and it leaves light at
/// grazing incidence to models that reflect it without a cosine.
const LEAST_COSINE: f64 = 1.0 / 256.0;

/// Cells per axis between which a node may be cut, as in the sources.
const BUCKETS: usize = 12;

/// From this depth on, cuts halve the number of lights, so that a way from the root fits 64 bits.
const HALVED_FROM: u32 = 30;

/// A surface point that light is wanted at.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    pub position: Vec3,
    /// Light counts only from the side this unit vector points to, by its cosine.
    pub normal: Vec3,
}

/// What the tree knows about one thing that shines.
#[derive(Clone, Copy, Debug)]
pub struct Luminary {
    /// Around all its points.
    pub bounds: Bounds,
    pub shines: Shines,
    /// Intensity in the direction in which it is strongest, seen from afar; not negative.
    pub intensity: f64,
}

/// Where something shines; flat things do so by the cosine to their unit normal.
#[derive(Clone, Copy, Debug)]
pub enum Shines {
    Everywhere,
    OneSide(Vec3),
    BothSides(Vec3),
}

/// The tree over things that shine, which are known by their numbers in the order given.
#[derive(Clone, Debug, Default)]
pub struct LightTree {
    /// The root is the first; empty where nothing shines.
    nodes: Vec<Node>,
    /// For each thing, the way from the root to it, see [`Trail`]; 0 for those that do not shine.
    trails: Vec<Trail>,
}

/// One of them and its number.
type Item = (u32, Luminary);

/// Which child to take at each level, from the lowest bit up, and then one bit that is set.
type Trail = u64;

#[derive(Clone, Copy, Debug)]
struct Node {
    cluster: Cluster,
    content: Content,
}

#[derive(Clone, Copy, Debug)]
enum Content {
    Item(u32),
    /// Index of the first of two neighbouring children.
    Children(u32),
}

/// What bounds some things that shine.
#[derive(Clone, Copy, Debug)]
struct Cluster {
    bounds: Bounds,
    /// Sum of the intensities.
    intensity: f64,
    /// All normals lie in the cone about this unit vector; where `both_sides`, they or their opposites do.
    axis: Vec3,
    /// Cosine and sine of the cone's half angle; π for what shines everywhere.
    cone: [f32; 2],
    both_sides: bool,
}

/// A number on its way down the tree.
#[derive(Clone, Copy, Debug, Default)]
struct Draw {
    index: u32,
    /// Uniform in `0..1`.
    u: f64,
}

impl Draw {
    /// Which of two children it leads to. What is left of the number is uniform again.
    fn pass(&mut self, shares: [f64; 2]) -> usize {
        let child = usize::from(self.u >= shares[0]);
        let left = if child == 0 {
            self.u / shares[0]
        } else {
            (self.u - shares[0]) / shares[1]
        };
        self.u = left.min(1.0_f64.next_down());
        child
    }
}

impl LightTree {
    /// The tree over `luminaries`, fewer than 2³¹ with finite numbers.
    ///
    /// # Panics
    /// When there are more.
    pub fn build(luminaries: &[Luminary]) -> Self {
        let count = u32::try_from(luminaries.len()).ok();
        let count = count.filter(|&count| count < 1 << 31);
        let numbers = 0..count.expect("fewer than 2^31 lights");
        let mut items: Vec<Item> = numbers.zip(luminaries.iter().copied()).collect();
        items.retain(|(_, luminary)| luminary.intensity > 0.0);
        let mut tree = Self {
            nodes: Vec::new(),
            trails: vec![0; luminaries.len()],
        };
        if items.is_empty() {
            return tree;
        }
        let placeholder = Node {
            cluster: Cluster::around(&[]),
            content: Content::Item(0),
        };
        tree.nodes.reserve_exact(2 * items.len() - 1);
        tree.nodes.push(placeholder);
        // Slot of the node, its part of `items`, its depth, the way to it.
        let mut open = vec![(0, 0..items.len(), 0_u32, 0_u64)];
        while let Some((slot, range, depth, way)) = open.pop() {
            let part = &mut items[range.clone()];
            let cluster = Cluster::around(part);
            let content = if let &[(item, _)] = &*part {
                tree.trails[item as usize] = way | 1 << depth;
                Content::Item(item)
            } else {
                let middle = range.start + cut(part, depth >= HALVED_FROM);
                let first = tree.nodes.len();
                tree.nodes.extend([placeholder; 2]);
                let second = way | 1 << depth;
                open.push((first + 1, middle..range.end, depth + 1, second));
                open.push((first, range.start..middle, depth + 1, way));
                Content::Children(u32::try_from(first).expect("twice the number of lights"))
            };
            tree.nodes[slot] = Node { cluster, content };
        }
        tree
    }

    /// Whether nothing shines.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The thing that `u`, uniform over the unit square, stands for at `at`, and its probability; `None` where the way leads to
    /// things that give nothing there.
    pub fn choose(&self, at: &Receiver, u: Vec2) -> Option<(usize, f32)> {
        let mut node = self.nodes.first()?;
        let mut draw = Draw {
            index: 0,
            u: joined(u),
        };
        let mut probability = 1.0;
        loop {
            let first = match node.content {
                #[expect(clippy::cast_possible_truncation, reason = "a probability")]
                Content::Item(item) => {
                    let probability = probability as f32;
                    return (probability > 0.0).then_some((item as usize, probability));
                }
                Content::Children(first) => first as usize,
            };
            let shares = self.shares(first, at)?;
            let child = draw.pass(shares);
            probability *= shares[child];
            node = &self.nodes[first + child];
        }
    }

    /// [`Self::choose`] for each of `numbers` uniform over the unit square, to the same bits, but on one way as far as they go
    /// together: `choose(index, item, probability)` for those that lead to something, in no order.
    pub fn choose_each(
        &self,
        at: &Receiver,
        numbers: impl Iterator<Item = Vec2>,
        mut choose: impl FnMut(u32, usize, f32),
    ) {
        let mut open = [Draw::default(); Self::MOST_TOGETHER];
        let mut count = 0;
        for (index, u) in (0..).zip(numbers) {
            open[count] = Draw {
                index,
                u: joined(u),
            };
            count += 1;
            if count == open.len() {
                self.descend(0, 1.0, at, &mut open, &mut choose);
                count = 0;
            }
        }
        if count > 0 {
            self.descend(0, 1.0, at, &mut open[..count], &mut choose);
        }
    }

    /// Draws that go down the tree together.
    const MOST_TOGETHER: usize = 64;

    /// Takes `draws`, at least one, from `node` down.
    fn descend(
        &self,
        node: usize,
        probability: f64,
        at: &Receiver,
        draws: &mut [Draw],
        choose: &mut impl FnMut(u32, usize, f32),
    ) {
        let Some(node) = self.nodes.get(node) else {
            return;
        };
        let first = match node.content {
            Content::Children(first) => first as usize,
            Content::Item(item) => {
                #[expect(clippy::cast_possible_truncation, reason = "a probability")]
                let probability = probability as f32;
                for draw in draws.iter().filter(|_| probability > 0.0) {
                    choose(draw.index, item as usize, probability);
                }
                return;
            }
        };
        let Some(shares) = self.shares(first, at) else {
            return;
        };
        let mut to_first = 0;
        for index in 0..draws.len() {
            let child = draws[index].pass(shares);
            if child == 0 {
                draws.swap(index, to_first);
                to_first += 1;
            }
        }
        let (left, right) = draws.split_at_mut(to_first);
        for (child, draws) in [left, right].into_iter().enumerate() {
            if !draws.is_empty() {
                self.descend(
                    first + child,
                    probability * shares[child],
                    at,
                    draws,
                    choose,
                );
            }
        }
    }

    /// The probability that [`Self::choose`] states for `item` at `at`, to the same bits.
    pub fn probability(&self, item: usize, at: &Receiver) -> f32 {
        let mut trail = self.trails[item];
        let mut index = 0;
        let mut probability = 1.0;
        while trail > 1 {
            let Content::Children(first) = self.nodes[index].content else {
                unreachable!("a way ends at its item");
            };
            let Some(shares) = self.shares(first as usize, at) else {
                return 0.0;
            };
            let child = usize::from(trail & 1 == 1);
            probability *= shares[child];
            index = first as usize + child;
            trail >>= 1;
        }
        #[expect(clippy::cast_possible_truncation, reason = "a probability")]
        let probability = probability as f32;
        if trail == 0 { 0.0 } else { probability }
    }

    /// How often each of two neighbouring nodes is taken; `None` where neither gives anything.
    fn shares(&self, first: usize, at: &Receiver) -> Option<[f64; 2]> {
        let [(a, a_squared), (b, b_squared)] =
            [first, first + 1].map(|index| self.nodes[index].cluster.importance(at));
        // Cross-multiplied. The range of f64 holds the products of anything f32 describes.
        let (a, b) = (a * b_squared, b * a_squared);
        let sum = a + b;
        (sum > 0.0).then(|| [a / sum, b / sum])
    }
}

impl Cluster {
    fn around(items: &[Item]) -> Self {
        let mut tally = Tally::EMPTY;
        for (_, luminary) in items {
            tally = tally.with(&Tally::of(luminary));
        }
        let axis = tally.normals.as_dvec3().normalize_or(DVec3::Z);
        let cosine_to_axis = |luminary: &Luminary| match luminary.shines {
            Shines::Everywhere => -1.0,
            Shines::OneSide(normal) | Shines::BothSides(normal) => {
                let cosine = axis.dot(normal.as_dvec3());
                if tally.both_sides {
                    cosine.abs()
                } else {
                    cosine
                }
            }
        };
        // Wider by what the narrowing of axis and normals may have moved them.
        let rounding = 4.0 * f64::from(f32::EPSILON);
        let cosines = items.iter().map(|(_, luminary)| cosine_to_axis(luminary));
        let cosine = cosines.fold(1.0, f64::min) - rounding;
        let cosine = cosine.max(-1.0);
        let sine = (1.0 - cosine * cosine).sqrt();
        #[expect(clippy::cast_possible_truncation, reason = "widened above")]
        let cone = [cosine as f32, sine as f32];
        Self {
            bounds: tally.bounds,
            intensity: tally.intensity,
            axis: axis.as_vec3(),
            cone,
            both_sides: tally.both_sides,
        }
    }

    /// What the cluster may give `at`, as a numerator and the square of a distance: intensity times the largest cosines that
    /// any of it may have at both ends, over the distance to its middle, no nearer than its size. 0 where it gives nothing.
    fn importance(&self, at: &Receiver) -> (f64, f64) {
        let (min, max) = (self.bounds.min.as_dvec3(), self.bounds.max.as_dvec3());
        let half = (max - min) * 0.5;
        let towards = (min + max) * 0.5 - at.position.as_dvec3();
        let (distance_squared, radius_squared) = (towards.length_squared(), half.length_squared());
        // The last digit of f32 stands for points that coincide.
        let apart = f64::from(f32::MIN_POSITIVE).powi(2);
        let measured = distance_squared.max(radius_squared).max(apart);
        let distance = measured.sqrt();

        let normal = at.normal.as_dvec3();
        let height = normal.dot(towards);
        // All corners of the box lie behind the surface.
        if height + normal.abs().dot(half) < -LEAST_COSINE * distance {
            return (0.0, measured);
        }
        // Within the ball around the box, any direction may be towards a light.
        if measured > distance_squared || radius_squared == distance_squared {
            return (self.intensity, measured);
        }

        let per_distance = 1.0 / distance;
        let ball = Angle::of_sine(radius_squared.sqrt() * per_distance);
        let received = Angle::of_cosine(height * per_distance).less(ball).cosine;
        let [cosine, sine] = self.cone.map(f64::from);
        let emitted = if cosine == -1.0 {
            1.0
        } else {
            let along = -self.axis.as_dvec3().dot(towards) * per_distance;
            let from_axis = Angle::of_cosine(if self.both_sides { along.abs() } else { along });
            from_axis.less(Angle { cosine, sine }).less(ball).cosine
        };
        if emitted < -LEAST_COSINE {
            return (0.0, measured);
        }
        let cosines = received.max(LEAST_COSINE) * emitted.max(LEAST_COSINE);
        (self.intensity * cosines, measured)
    }
}

/// An angle between 0 and π.
#[derive(Clone, Copy)]
struct Angle {
    cosine: f64,
    sine: f64,
}

impl Angle {
    fn of_cosine(cosine: f64) -> Self {
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        Self { cosine, sine }
    }

    /// The one up to π/2.
    fn of_sine(sine: f64) -> Self {
        let cosine = (1.0 - sine * sine).max(0.0).sqrt();
        Self { cosine, sine }
    }

    /// The difference, or 0 where `other` is larger.
    fn less(self, other: Self) -> Self {
        if self.cosine >= other.cosine {
            return Self {
                cosine: 1.0,
                sine: 0.0,
            };
        }
        Self {
            cosine: self.cosine * other.cosine + self.sine * other.sine,
            sine: self.sine * other.cosine - self.cosine * other.sine,
        }
    }
}

/// What can be said of some things that shine by adding up what is known of each.
#[derive(Clone, Copy)]
struct Tally {
    bounds: Bounds,
    intensity: f64,
    /// Sum of the normals; those of things that shine on both sides count with the sign that makes it longer.
    normals: Vec3,
    both_sides: bool,
    count: u32,
}

impl Tally {
    const EMPTY: Self = Self {
        bounds: Bounds::EMPTY,
        intensity: 0.0,
        normals: Vec3::ZERO,
        both_sides: false,
        count: 0,
    };

    fn of(luminary: &Luminary) -> Self {
        let (normals, both_sides) = match luminary.shines {
            Shines::Everywhere => (Vec3::ZERO, false),
            Shines::OneSide(normal) => (normal, false),
            Shines::BothSides(normal) => (normal, true),
        };
        Self {
            bounds: luminary.bounds,
            intensity: luminary.intensity,
            normals,
            both_sides,
            count: 1,
        }
    }

    fn with(&self, other: &Self) -> Self {
        let against = other.both_sides && self.normals.dot(other.normals) < 0.0;
        Self {
            bounds: self.bounds.union(other.bounds),
            intensity: self.intensity + other.intensity,
            normals: if against {
                self.normals - other.normals
            } else {
                self.normals + other.normals
            },
            both_sides: self.both_sides || other.both_sides,
            count: self.count + other.count,
        }
    }

    /// How ill a node over these would tell lights apart: intensity, size and spread of the directions they shine in. The size
    /// is the squared diagonal, as areas vanish for lights in a row. The directions fill a solid angle from π, of one flat
    /// light, to 4π; the mean normal says about how much of that, and adds up, which a cone does not.
    fn cost(&self) -> f64 {
        if self.count == 0 {
            return 0.0;
        }
        let mean = self.normals.length() / self.count as f32;
        let solid_angle = f64::from(1.0 + 3.0 * (1.0 - mean));
        self.intensity * self.bounds.size().as_dvec3().length_squared() * solid_angle
    }
}

/// Reorders at least two `items` and returns where to cut: between cells along one axis where the cost of both sides is least,
/// or in the middle.
fn cut(items: &mut [Item], halve: bool) -> usize {
    let middle = items.len() / 2;
    if halve || items.len() == 2 {
        return middle;
    }
    let center = |(_, luminary): &Item| luminary.bounds.center();
    let centers = Bounds::of_points(items.iter().map(center));
    let size = centers.size();
    let buckets = BUCKETS.min(items.len());
    let per_size = Vec3::splat(buckets as f32) / size;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a cell's number"
    )]
    let bucket = |item: &Item, axis: usize| {
        let along = (center(item)[axis] - centers.min[axis]) * per_size[axis];
        (along as usize).min(buckets - 1)
    };
    let mut tallies = [[Tally::EMPTY; BUCKETS]; 3];
    for item in &*items {
        let tally = Tally::of(&item.1);
        for axis in 0..3 {
            let cell = &mut tallies[axis][bucket(item, axis)];
            *cell = cell.with(&tally);
        }
    }
    // Cost, axis, first cell of the second side.
    let mut best = (f64::INFINITY, 0, 0);
    for axis in 0..3 {
        let tallies = &tallies[axis][..buckets];
        let mut after = [0.0; BUCKETS];
        let mut right = Tally::EMPTY;
        for (index, tally) in tallies.iter().enumerate().rev() {
            right = right.with(tally);
            after[index] = right.cost();
        }
        // Thin slices of long nodes cost more, as in the sources.
        let thinness = f64::from(size.max_element() / size[axis]);
        let mut left = Tally::EMPTY;
        for index in 1..buckets {
            left = left.with(&tallies[index - 1]);
            let cost = thinness * (left.cost() + after[index]);
            let splits = 0 < left.count && left.count < right.count;
            if splits && cost < best.0 {
                best = (cost, axis, index);
            }
        }
    }
    let (cost, axis, first) = best;
    if cost == f64::INFINITY {
        return middle;
    }
    let mut left = 0;
    for index in 0..items.len() {
        if bucket(&items[index], axis) < first {
            items.swap(left, index);
            left += 1;
        }
    }
    left
}

/// One number in `(0, 1)` with the digits of both, 24 each, as many lights need more than one has. It is the middle of its
/// step, so that nothing far less likely than a step is ever chosen.
fn joined(u: Vec2) -> f64 {
    const STEP: f64 = 1.0 / (1_u32 << 24) as f64;
    f64::from(u.x) + (f64::from(u.y) + 0.5 * STEP) * STEP
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::shapes::Random;

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
        let tree = LightTree::build(&luminaries);
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
        let tree = LightTree::build(&luminaries(500, Random::unit));
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
            let tree = LightTree::build(lights);
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
        let tree = LightTree::build(&luminaries);
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
        let tree = LightTree::build(&row);
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
        let tree = LightTree::build(&lights);
        assert_eq!(tree.nodes.len(), 19);
        let at = receiver(&mut Random::new(1));
        assert!((10..60).all(|item| tree.probability(item, &at) == 0.0));
        assert!(LightTree::build(&lights[10..]).is_empty());
        assert!(LightTree::build(&[]).choose(&at, Vec2::ZERO).is_none());
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
            let tree = LightTree::build(&lights);
            assert_eq!(tree.nodes.len(), 2 * lights.len() - 1);
            let deepest = tree.trails.iter().map(|trail| 63 - trail.leading_zeros());
            assert!(deepest.max() < Some(HALVED_FROM + 18));
        }
    }
}
