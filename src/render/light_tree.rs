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

mod cluster;
mod cut;
#[cfg(test)]
mod tests;

use cluster::Cluster;
use cut::cut;

use crate::control::CancelToken;
use crate::math::{Bounds, Vec2, Vec3};

/// Lights between two looks at the cancel token.
const CHUNK: usize = 1 << 14;

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
    /// The tree over `luminaries`, fewer than 2³¹ with finite numbers; `None` when cancelled.
    ///
    /// # Panics
    /// When there are more.
    pub fn build(luminaries: &[Luminary], cancel: &CancelToken) -> Option<Self> {
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
            return Some(tree);
        }
        let placeholder = Node {
            cluster: Cluster::around(&[], cancel),
            content: Content::Item(0),
        };
        tree.nodes.reserve_exact(2 * items.len() - 1);
        tree.nodes.push(placeholder);
        // Slot of the node, its part of `items`, its depth, the way to it.
        let mut open = vec![(0, 0..items.len(), 0_u32, 0_u64)];
        while let Some((slot, range, depth, way)) = open.pop() {
            let part = &mut items[range.clone()];
            if cancel.is_cancelled() {
                return None;
            }
            let cluster = Cluster::around(part, cancel);
            let content = if let &[(item, _)] = &*part {
                tree.trails[item as usize] = way | 1 << depth;
                Content::Item(item)
            } else {
                let middle = range.start + cut(part, depth >= HALVED_FROM, cancel);
                let first = tree.nodes.len();
                tree.nodes.extend([placeholder; 2]);
                let second = way | 1 << depth;
                open.push((first + 1, middle..range.end, depth + 1, second));
                open.push((first, range.start..middle, depth + 1, way));
                Content::Children(u32::try_from(first).expect("twice the number of lights"))
            };
            tree.nodes[slot] = Node { cluster, content };
        }
        (!cancel.is_cancelled()).then_some(tree)
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

/// One number in `(0, 1)` with the digits of both, 24 each, as many lights need more than one has. It is the middle of its
/// step, so that nothing far less likely than a step is ever chosen.
fn joined(u: Vec2) -> f64 {
    const STEP: f64 = 1.0 / (1_u32 << 24) as f64;
    f64::from(u.x) + (f64::from(u.y) + 0.5 * STEP) * STEP
}
