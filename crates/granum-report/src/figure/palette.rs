//! Colours and sizes that all figures share.

/// Colour of frames, ticks and text.
pub const INK: &str = "#1a1a1a";
/// Secondary colour, for notes and reference lines.
pub const GREY: &str = "#6b6b6b";
/// Light grey for the background.
pub const PALE: &str = "#d9d9d9";

/// Size of axis labels, px.
pub const LABEL_SIZE: f64 = 12.5;
/// Size of tick labels, legends and notes, px.
pub const TICK_SIZE: f64 = 11.0;
/// Size of the letter of a panel, px.
pub const TAG_SIZE: f64 = 13.5;

/// Colours that can be distinguished with all common colour-vision deficiencies, and by their lightness in greyscale print
/// (Okabe and Ito 2008, without yellow).
pub const COLORS: [&str; 6] = ["#0072b2", "#d55e00", "#009e73", "#aa4499", "#e69f00", "#56b4e9"];

/// Colour k of [`COLORS`], which repeat after the last one.
pub fn color(k: usize) -> &'static str {
    COLORS[k % COLORS.len()]
}

/// Stops of a sequential colour scale from light to dark with equal steps of lightness: from pale sand over orange and
/// magenta to nearly black, readable in greyscale print and with any colour-vision deficiency.
const SEQUENTIAL: [[f64; 3]; 6] = [
    [246.0, 215.0, 160.0],
    [245.0, 166.0, 98.0],
    [226.0, 99.0, 83.0],
    [170.0, 51.0, 106.0],
    [98.0, 24.0, 110.0],
    [30.0, 10.0, 66.0],
];

/// A colour of the sequential scale at `t` in 0..1, mixed with a share `white` of white.
pub fn sequential(t: f64, white: f64) -> String {
    let t = if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.0 } * (SEQUENTIAL.len() - 1) as f64;
    let k = (t as usize).min(SEQUENTIAL.len() - 2);
    let part = t - k as f64;
    let rgb = std::array::from_fn(|c| SEQUENTIAL[k][c] + part * (SEQUENTIAL[k + 1][c] - SEQUENTIAL[k][c]));
    hex(rgb, white)
}

/// A colour from its red, green and blue in 0..255, mixed with a share `white` of white.
pub fn hex(rgb: [f64; 3], white: f64) -> String {
    let [r, g, b] = rgb.map(|c| (c + white.clamp(0.0, 1.0) * (255.0 - c)).round().clamp(0.0, 255.0) as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequential_scale_darkens_evenly() {
        let lightness = |t: f64| {
            let text = sequential(t, 0.0);
            let part = |k: usize| u8::from_str_radix(&text[k..k + 2], 16).unwrap() as f64;
            0.299 * part(1) + 0.587 * part(3) + 0.114 * part(5)
        };
        let steps: Vec<f64> =
            (0..5).map(|k| lightness(k as f64 / 5.0) - lightness((k + 1) as f64 / 5.0)).collect();
        assert!(steps.iter().all(|&step| (20.0..60.0).contains(&step)), "{steps:?}");
        assert_eq!(sequential(0.5, 1.0), "#ffffff");
        assert_eq!(sequential(f64::NAN, 0.0), sequential(0.0, 0.0));
    }
}
