use super::*;

#[derive(Debug)]
struct Everything {
    a: WideLanes,
    b: WideLanes,
    c: WideLanes,
}

/// What [`Everything`] gives.
#[derive(Default)]
struct Results {
    /// Numbers that must agree in every bit, `f32` as the `f64` that they are.
    exact: Vec<f64>,
    sets: Vec<LaneSet>,
    /// The least and the greatest of numbers without NaN, where of two zeros either will do.
    extremes: Vec<f32>,
    /// Products with sums that may be rounded once or twice, of each lane.
    fused: Vec<[f32; 2]>,
}

impl Results {
    /// Takes note of all there is for `f32`.
    fn of_floats<R: Copy, S: Floats<R>>(
        &mut self,
        simd: S,
        [a, b, c]: [R; 3],
        numbers: impl Fn(R) -> Vec<f32>,
    ) {
        let mut exact = arithmetic(simd, [a, b]).to_vec();
        exact.push(simd.splat(numbers(a)[0]));
        for register in exact {
            self.exact
                .extend(numbers(register).into_iter().map(f64::from));
        }
        self.sets
            .extend([simd.less(a, b), simd.less_or_equal(a, b)]);
        if !numbers(a).iter().any(|x| x.is_nan()) {
            self.extremes.extend([simd.least(a), simd.greatest(a)]);
        }
        let sums = numbers(simd.mul_add(a, b, c));
        let differences = numbers(simd.mul_sub(a, b, c));
        let pairs = sums.into_iter().zip(differences);
        self.fused
            .extend(pairs.map(|(sum, difference)| [sum, difference]));
    }

    /// Takes note of all there is for `f64`, lane by lane, as registers differ in length.
    fn of_doubles<R: Copy, S: Doubles<R>>(&mut self, simd: S, [a, b]: [R; 2]) {
        let mut exact = arithmetic(simd, [a, b]).to_vec();
        exact.push(simd.splat_double(1e300));
        let columns: Vec<_> = exact.iter().map(|&x| simd.store_doubles(x)).collect();
        let rounded: Vec<_> = exact.iter().map(|&x| simd.store_rounded(x)).collect();
        let sets = [simd.less(a, b), simd.less_or_equal(a, b)];
        for lane in 0..columns[0].len() {
            self.exact.extend(columns.iter().map(|column| column[lane]));
            let rounded = rounded.iter().map(|column| f64::from(column.0[lane]));
            self.exact.extend(rounded);
            let is_in = |set: &LaneSet| if set.contains(lane) { 1.0 } else { 0.0 };
            self.exact.extend(sets.iter().map(is_in));
        }
    }
}

fn arithmetic<R: Copy, S: Arithmetic<R>>(simd: S, [a, b]: [R; 2]) -> [R; 7] {
    [
        simd.add(a, b),
        simd.sub(a, b),
        simd.mul(a, b),
        simd.div(a, b),
        simd.abs(a),
        simd.smaller(a, b),
        simd.larger(a, b),
    ]
}

impl Query for Everything {
    type Answer = Results;

    fn answer<S: Simd>(&self, simd: S) -> Results {
        let mut results = Results::default();
        let wide = [&self.a, &self.b, &self.c].map(|lanes| simd.load_wide(lanes));
        results.of_floats(simd, wide, |x| simd.store_wide(x).0.to_vec());
        let eight = [&self.a, &self.b, &self.c].map(|lanes| {
            let (eights, _) = lanes.0.as_chunks();
            simd.load(&Lanes(eights[0]))
        });
        results.of_floats(simd, eight, |x| simd.store(x).0.to_vec());
        for start in (0..WIDE_LANES).step_by(DOUBLES) {
            let four = |lanes: &WideLanes| {
                let (four, _) = lanes.0[start..].split_first_chunk().unwrap();
                simd.load_doubles(four)
            };
            results.of_doubles::<S::F64x4, S>(simd, [four(&self.a), four(&self.b)]);
        }
        // Registers of different lengths come to the same numbers in the end.
        for start in (0..WIDE_LANES).step_by(S::DOUBLES_PER_REGISTER) {
            let mut places = [Places::default(); 2];
            for index in 0..S::DOUBLES_PER_REGISTER {
                places[0].put(index, start + index);
                places[1].put(index, (start + index) * 3 % LANES);
            }
            let (eights, _) = self.b.0.as_chunks();
            let numbers = [
                simd.pick_wide(&self.a, places[0]),
                simd.pick(&Lanes(eights[1]), places[1]),
            ];
            results.of_doubles::<S::F64s, S>(simd, numbers);
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
        -3.75,
    ];
    // Of every third run of lanes the NaN is left out, as it has no place among the extremes.
    let lanes = |first: usize, step: usize, without_nan: bool| {
        let at = |i: usize| special[(first + i * step) % special.len()];
        WideLanes(
            std::array::from_fn(at).map(|x: f32| if without_nan && x.is_nan() { 7.0 } else { x }),
        )
    };
    for turn in 0..1331 {
        let query = Everything {
            a: lanes(turn, 1, turn % 3 == 0),
            b: lanes(turn / 11, 3, false),
            c: lanes(turn / 121, 7, false),
        };
        let answers = answers(&query);
        let (portable, others) = answers.split_first().unwrap();
        assert!(turn % 3 > 0 || portable.extremes.len() == 4);
        for wide in others {
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
            let products = product.iter().chain(&product[..LANES]);
            assert_eq!(wide.fused.len(), WIDE_LANES + LANES);
            for ((wide, portable), product) in wide.fused.iter().zip(&portable.fused).zip(products)
            {
                for (wide, portable) in wide.iter().zip(portable) {
                    let most = (product.abs() + portable.abs()) * f32::EPSILON;
                    let overflown = !wide.is_finite() || !portable.is_finite();
                    assert!((wide - portable).abs() <= most || overflown, "{query:?}");
                }
            }
        }
    }
}

#[test]
fn sets_of_lanes_count_up() {
    let set = LaneSet(0b100_0010);
    let lanes: Vec<_> = set.into_iter().collect();
    assert_eq!(lanes, [1, 6]);
    let four = |index: usize, bits: u32| Four {
        index,
        lanes: LaneSet(bits),
    };
    let fours: Vec<_> = set.fours().collect();
    assert_eq!(fours, [four(0, 2), four(1, 4)]);
    let last: Vec<_> = LaneSet(0b1001 << 12).fours().collect();
    assert_eq!(
        (last.as_slice(), last[0].first()),
        ([four(3, 0b1001)].as_slice(), 12)
    );
    let one = LaneSet(2);
    assert_eq!((set.and(one), set.and_not(one)), (one, LaneSet(64)));
    assert!(set.and_not(set).into_iter().is_empty());
}
