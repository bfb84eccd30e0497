//! What a word may have been meant to be: names of other renderers, and misspellings.

/// What a key of other renderers is called here.
pub fn counterpart(key: &str) -> Option<&'static str> {
    Some(match key {
        "fov" | "angle" => "vertical_fov",
        "origin" | "look_from" | "lookfrom" => "eye",
        "look_at" | "lookat" => "target",
        "lens_radius" | "aperture" => "aperture_radius",
        "spp" | "samples" => "samples_per_pixel",
        "max_depth" | "depth" => "max_bounces",
        "color" | "colour" | "albedo" | "base_color" => "diffuse",
        "exponent" => "shininess",
        "absorption" | "transmittance" => "attenuation",
        "emission" => "radiance",
        "file" | "filename" | "shape" => "mesh",
        "translation" => "translate",
        "rotation" => "rotate",
        _ => return None,
    })
}

/// Whether one word may be a misspelling of the other: at most half of its letters differ.
pub fn is_near(word: &str, other: &str) -> bool {
    2 * distance(word, other) <= word.chars().count().max(2)
}

/// The candidate that takes the fewest edits to reach.
pub fn nearest<'n>(word: &str, candidates: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    candidates.min_by_key(|candidate| distance(word, candidate))
}

/// Edits from a word to another. That only the beginning of the other is meant counts as one.
pub fn distance(word: &str, other: &str) -> usize {
    let beginning: String = other.chars().take(word.chars().count()).collect();
    edits(word, other).min(1 + edits(word, &beginning))
}

/// Edits from one word to the other, as far as people make words: time and memory are the product of the lengths.
fn edits(word: &str, other: &str) -> usize {
    const LONGEST: usize = 32;
    let beginning = |text: &str| text.chars().take(LONGEST).collect::<String>();
    strsim::damerau_levenshtein(&beginning(word), &beginning(other))
}
