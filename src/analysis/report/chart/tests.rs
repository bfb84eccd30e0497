use super::drawing::escaped;
use super::*;

fn spread(median: f64) -> Spread {
    Spread {
        median,
        min: 0.8 * median,
        max: 1.3 * median,
    }
}

fn curve(color: usize, points: &[(f64, f64)]) -> Curve {
    let point = |&(x, y)| Point { x, y: spread(y) };
    Curve {
        name: format!("curve {color}"),
        note: None,
        color,
        line: Line::Solid,
        band: true,
        points: points.iter().map(point).collect(),
    }
}

fn chart(curves: Vec<Curve>) -> Chart {
    Chart {
        title: "Error against time".to_owned(),
        x: Axis {
            label: "run time".to_owned(),
            unit: Unit::Seconds,
        },
        y: Axis {
            label: "relative error".to_owned(),
            unit: Unit::Percent,
        },
        curves,
        levels: vec![],
        caption: vec!["64 threads".to_owned()],
    }
}

/// The texts of a document, after seeing that it is well-formed: tags are closed in order, attributes quoted, and what is
/// between them escaped.
fn texts(svg: &str) -> Vec<String> {
    let (mut open, mut texts) = (Vec::new(), Vec::new());
    let mut parts = svg.split('<');
    assert_eq!(parts.next(), Some(""));
    for part in parts {
        let (tag, text) = part.split_once('>').expect("tags end");
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        assert!(!text.contains('>'), "{text}");
        for entity in text.split('&').skip(1) {
            let known = ["amp;", "lt;", "gt;"];
            assert!(
                known.iter().any(|known| entity.starts_with(known)),
                "{text}"
            );
        }
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !tag.ends_with('/') {
            open.push(tag.split(' ').next().expect("a name"));
        }
        if !text.trim().is_empty() {
            texts.push(text.to_owned());
        }
        assert!(
            !open.is_empty() || text == "\n",
            "one root, and nothing after it"
        );
    }
    assert!(open.is_empty(), "{open:?}");
    for word in ["NaN", "inf", "-0.00"] {
        assert!(!svg.contains(word), "{word}");
    }
    texts
}

#[test]
fn a_chart_holds_its_texts_and_is_the_same_again() {
    let mut chart = chart(vec![curve(0, &[(0.5, 0.2), (8.0, 0.05)])]);
    chart.curves[0].note = Some("slope −0.50".to_owned());
    chart.levels.push(Level {
        y: 0.03,
        label: "the goal".to_owned(),
    });
    let svg = chart.to_svg();
    let texts = texts(&svg);
    for text in [
        "Error against time",
        "run time",
        "relative error",
        "1 s",
        "10 %",
        "curve 0",
        "slope −0.50",
        "the goal",
        "64 threads",
    ] {
        assert!(texts.iter().any(|t| t == text), "{text}: {texts:?}");
    }
    assert_eq!(svg, chart.clone().to_svg());
}

#[test]
fn chart_points_are_where_they_belong() {
    // The ranges are those around 0.1 to 10 and 0.08 to 1.3, margins included: 0.05 to 20 and 0.05 to 2.
    let chart = chart(vec![curve(0, &[(0.1, 0.1), (1.0, 1.0), (10.0, 0.1)])]);
    let (svg, layout) = (chart.to_svg(), Layout::of(&chart));
    let x = |value: f64| {
        layout.left + (layout.right - layout.left) * (value / 0.05).log10() / 400_f64.log10()
    };
    let y = |value: f64| {
        layout.bottom - (layout.bottom - layout.top) * (value / 0.05).log10() / 40_f64.log10()
    };
    let line = format!(
        r#"d="M{:.2} {low:.2}L{:.2} {:.2}L{:.2} {low:.2}""#,
        x(0.1),
        x(1.0),
        y(1.0),
        x(10.0),
        low = y(0.1)
    );
    assert!(svg.contains(&line), "{line}\n{svg}");
}

#[test]
fn chart_texts_are_escaped() {
    let nasty = "a < b & \"c\" > 'd'\n\u{0}\u{ffff}";
    let expected = "a &lt; b &amp; \"c\" &gt; 'd' \u{fffd}\u{fffd}";
    assert_eq!(escaped(nasty), expected);
    let mut chart = chart(vec![curve(0, &[(1.0, 1.0)])]);
    chart.levels.push(Level {
        y: 1.0,
        label: nasty.to_owned(),
    });
    chart.curves[0].name = nasty.to_owned();
    chart.curves[0].note = Some(nasty.to_owned());
    for text in [
        &mut chart.title,
        &mut chart.x.label,
        &mut chart.y.label,
        &mut chart.caption[0],
    ] {
        nasty.clone_into(text);
    }
    let texts = texts(&chart.to_svg());
    assert_eq!(texts.iter().filter(|text| *text == expected).count(), 8);
}

#[test]
fn a_chart_says_how_many_values_it_leaves_out() {
    let nan = f64::NAN;
    let bad = [(0.0, 1.0), (1.0, -1.0), (nan, 1.0), (1.0, f64::INFINITY)];
    let mut chart = chart(vec![curve(0, &bad), curve(1, &[(1.0, 2.0)])]);
    let left_out = |chart: &Chart| {
        let texts = texts(&chart.to_svg());
        texts.into_iter().find(|text| text.contains("not shown"))
    };
    let note = left_out(&chart).expect("a note");
    assert!(note.starts_with("4 values"), "{note}");
    chart.curves[1].points[0].y.min = nan;
    chart.levels.push(Level {
        y: 0.0,
        label: String::new(),
    });
    let note = left_out(&chart).expect("a note");
    assert!(note.starts_with("6 values"), "{note}");
    chart.levels.clear();
    chart.curves.remove(0);
    let note = left_out(&chart).expect("a note");
    assert!(note.starts_with("1 value "), "{note}");
    chart.curves[0].points[0].y = spread(1.0);
    assert_eq!(left_out(&chart), None);
}

#[test]
fn charts_of_anything_are_well_formed() {
    let extremes = [(f64::from_bits(1), f64::MAX / 2.0), (f64::MAX, 1e-300)];
    let tall = (0..40).map(|color| curve(color, &[(1.0, 1.0)])).collect();
    for curves in [
        vec![],
        vec![curve(0, &[])],
        vec![curve(usize::MAX, &[(1.0, 1.0)])],
        vec![curve(0, &[(1.0, 1.0), (1.0, 1.0)])],
        vec![curve(0, &extremes)],
        vec![curve(0, &[(1e-4, 0.1), (1e4, 1e-9)]), curve(1, &[])],
        tall,
    ] {
        let mut chart = chart(curves);
        let empty = chart.curves.iter().all(|curve| curve.points.is_empty());
        let texts_of = texts(&chart.to_svg());
        assert_eq!(
            texts_of.iter().any(|text| text == "no values to show"),
            empty
        );
        for curve in &mut chart.curves {
            curve.band = false;
            curve.line = Line::Dotted;
        }
        texts(&chart.to_svg());
    }
}

#[test]
fn chart_ranges_beyond_the_axis_end_at_the_frame() {
    let mut chart = chart(vec![curve(0, &[(1.0, 1.0)])]);
    chart.curves[0].points[0].y = Spread {
        median: 1.0,
        min: -1.0,
        max: f64::INFINITY,
    };
    let (svg, layout) = (chart.to_svg(), Layout::of(&chart));
    let x = f64::midpoint(layout.left, layout.right);
    let bar = format!("M{x:.2} {:.2}L{x:.2} {:.2}z", layout.top, layout.bottom);
    assert!(svg.contains(&bar), "{bar}\n{svg}");
    texts(&svg);
}

#[test]
fn chart_labels_of_levels_do_not_meet() {
    let mut chart = chart(vec![curve(0, &[(1.0, 1e-6), (2.0, 1.0)])]);
    let level = |y| Level {
        y,
        label: format!("{y}"),
    };
    chart.levels = [0.0299, 0.1, 0.03, 0.0301].map(level).to_vec();
    let layout = Layout::of(&chart);
    let levels = layout.levels(&chart);
    let order: Vec<_> = levels.iter().map(|(level, ..)| level.y).collect();
    assert_eq!(order, [0.1, 0.0301, 0.03, 0.0299]);
    for pair in levels.windows(2) {
        assert!(pair[1].2 - pair[0].2 >= 12.0, "{pair:?}");
    }
    assert_eq!(levels[1].1, levels[1].2);
}

/// Names as long as command lines stand in several lines beside the plot; all of them, where they are not longer than anybody reads.
#[test]
fn long_names_do_not_widen_a_chart() {
    let mut chart = chart(vec![curve(0, &[(1.0, 1.0)]), curve(1, &[(1.0, 2.0)])]);
    let settings =
        "render.ambient_occlusion.samples=16; render.light_sampling=bsdf; render.stop.noise=0.003";
    settings.clone_into(&mut chart.curves[0].name);
    chart.curves[0].note = Some("slope −0.72 (−1.67 – −0.70); by CPU time −0.71".to_owned());
    let found = texts(&chart.to_svg());
    let words: Vec<&str> = found.iter().flat_map(|text| text.split(' ')).collect();
    let split = [
        "16;",
        "render.light_sampling=bsdf;",
        "render.stop.noise=0.003",
    ];
    assert!(
        split
            .iter()
            .all(|part| words.iter().any(|w| w.ends_with(part))),
        "{found:?}"
    );
    for name in [settings.repeat(20), "x".repeat(2000), settings.to_owned()] {
        chart.curves[0].name = name;
        let layout = Layout::of(&chart);
        assert!(layout.width < 1000.0, "{}", layout.width);
        let below = layout.top + layout::legend_height(&chart.curves[0]);
        assert!(below <= layout.bottom, "{below}");
        texts(&chart.to_svg());
    }
}

#[test]
fn chart_colors_and_markers_repeat_after_28() {
    let manner = |color| {
        let mut curve = curve(color, &[(1.0, 1.0)]);
        curve.name.clear();
        let svg = chart(vec![curve]).to_svg();
        let marker = svg
            .lines()
            .rfind(|line| line.contains("stroke-width=\"1.5\""));
        marker.expect("a marker").to_owned()
    };
    let mut seen: Vec<_> = (0..28).map(manner).collect();
    assert_eq!(manner(28), seen[0]);
    seen.sort();
    seen.dedup();
    assert_eq!(seen.len(), 28);
}
