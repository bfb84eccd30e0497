use super::*;

#[derive(Debug)]
struct Everything {
    a: Lanes,
    b: Lanes,
    c: Lanes,
}

/// What [`Everything`] gives.
#[derive(Default)]
struct Results {
    /// Numbers that must agree in every bit, `f32` as the `f64` that they are.
    exact: Vec<f64>,
    sets: Vec<LaneSet>,
    /// The least and the greatest of numbers without NaN, where of two zeros either will do.
    extremes: Vec<f32>,
    /// Products with sums that may be rounded once or twice.
    fused: Vec<[f32; LANES]>,
}

impl Query for Everything {
    type Answer = Results;

    fn answer<S: Simd>(&self, simd: S) -> Results {
        let mut results = Results::default();
        let [a, b, c] = [&self.a, &self.b, &self.c].map(|lanes| simd.load(lanes));
        let exact = [
            simd.add(a, b),
            simd.sub(a, b),
            simd.mul(a, b),
            simd.div(a, b),
            simd.abs(a),
            simd.smaller(a, b),
            simd.larger(a, b),
            simd.splat(self.a.0[0]),
        ];
        for register in exact {
            results.exact.extend(simd.store(register).0.map(f64::from));
        }
        results.sets = vec![simd.less(a, b), simd.less_or_equal(a, b)];
        if !self.a.0.iter().any(|x| x.is_nan()) {
            results.extremes = vec![simd.least(a), simd.greatest(a)];
        }
        let fused = [simd.mul_add(a, b, c), simd.mul_sub(a, b, c)];
        results.fused = fused.map(|x| simd.store(x).0).to_vec();
        for half in [Half::Lower, Half::Upper] {
            let [a, b] = [&self.a, &self.b].map(|lanes| simd.load_half(lanes, half));
            let exact = [
                simd.add(a, b),
                simd.sub(a, b),
                simd.mul(a, b),
                simd.div(a, b),
                simd.abs(a),
                simd.smaller(a, b),
                simd.larger(a, b),
                simd.splat_double(f64::from(self.a.0[0]) * 1e100),
            ];
            for register in exact {
                results.exact.extend(simd.store_double(register));
                let rounded = simd.store_rounded(register);
                results.exact.extend(rounded.map(f64::from));
            }
            results
                .sets
                .extend([simd.less(a, b), simd.less_or_equal(a, b)]);
        }
        results
    }
}

/// On machines without wide instructions, the same code twice.
#[test]
fn wide_instructions_work_as_the_portable_ones() {
    let special = [
        0.0,
        -0.0,
        1.0,
        -2.5,
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MIN_POSITIVE / 4.0,
        f32::MAX,
        1.0 + f32::EPSILON,
    ];
    let lanes = |first: usize, step: usize| {
        let at = |i: usize| special[(first + i * step) % special.len()];
        Lanes(std::array::from_fn(at))
    };
    for turn in 0..1000 {
        let query = Everything {
            a: lanes(turn, 1),
            b: lanes(turn / 10, 3),
            c: lanes(turn / 100, 7),
        };
        let (wide, portable) = (answer(&query), query.answer(Portable));
        let bits = |numbers: &[f64]| -> Vec<_> {
            // Which NaN it is does not matter.
            let bits = |x: &f64| if x.is_nan() { None } else { Some(x.to_bits()) };
            numbers.iter().map(bits).collect()
        };
        assert_eq!(bits(&wide.exact), bits(&portable.exact));
        assert_eq!(wide.sets, portable.sets);
        assert_eq!(wide.extremes, portable.extremes);
        // The product is rounded, or not, and the sum is rounded.
        let product = Portable.mul(query.a.0, query.b.0);
        for (wide, portable) in wide.fused.iter().zip(&portable.fused) {
            for (lane, product) in product.iter().enumerate() {
                let (wide, portable) = (wide[lane], portable[lane]);
                let most = (product.abs() + portable.abs()) * f32::EPSILON;
                let overflown = !wide.is_finite() || !portable.is_finite();
                assert!((wide - portable).abs() <= most || overflown, "{query:?}");
            }
        }
    }
}

#[test]
fn sets_of_lanes_count_up() {
    let set = LaneSet(0b100_0010);
    let lanes: Vec<_> = set.into_iter().collect();
    assert_eq!(lanes, [1, 6]);
    let halves: Vec<_> = set.halves().collect();
    assert_eq!(
        halves,
        [(Half::Lower, LaneSet(2)), (Half::Upper, LaneSet(4))]
    );
    let upper: Vec<_> = LaneSet(0b1000_0000).halves().collect();
    assert_eq!(upper, [(Half::Upper, LaneSet(8))]);
    let one = LaneSet(2);
    assert_eq!((set.and(one), set.and_not(one)), (one, LaneSet(64)));
    assert!(set.and_not(set).into_iter().is_empty());
}
