//! A list of what to draw, in pixels, rendered once as PNG and once as SVG.
//!
//! PNG is drawn three times too large and averaged, which smooths every edge. The font comes with the program, so that
//! pictures look the same on a machine that has none.

use std::io::Write;
use std::path::Path;
use std::sync::Once;

use anyhow::{Result, anyhow};
use plotters::backend::{BitMapBackend, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, FontTransform, IntoFont, RGBColor, TextStyle, register_font};
use plotters_backend::{BackendColor, BackendStyle, DrawingBackend};

use crate::files;

/// Red, green, blue.
pub type Color = [u8; 3];

/// Where a text's reference point lies in it, horizontally. Vertically it is the middle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// The text begins there.
    Start,
    /// Its middle is there.
    Middle,
    /// It ends there.
    End,
}

#[derive(Clone, Debug)]
enum Op {
    Line { points: Vec<[f64; 2]>, color: Color, width: f64 },
    Rect { low: [f64; 2], high: [f64; 2], color: Color },
    Dot { at: [f64; 2], radius: f64, color: Color, filled: bool },
    Text { at: [f64; 2], text: String, size: f64, anchor: Anchor, upwards: bool, color: Color },
}

/// What to draw.
#[derive(Clone, Debug)]
pub struct Canvas {
    size: [u32; 2],
    ops: Vec<Op>,
}

/// How many times larger the picture is drawn.
const FINE: u32 = 3;

impl Canvas {
    /// A white canvas of this many pixels.
    pub fn new(width: u32, height: u32) -> Self {
        Self { size: [width, height], ops: Vec::new() }
    }

    /// A line through points; `dash` holds the lengths of strokes and gaps, nothing for a solid line.
    pub fn line(&mut self, points: &[[f64; 2]], color: Color, width: f64, dash: &[f64]) {
        if dash.is_empty() {
            if points.len() > 1 {
                self.ops.push(Op::Line { points: points.to_vec(), color, width });
            }
            return;
        }
        let (mut index, mut left, mut stroke) = (0, dash[0], Vec::new());
        for pair in points.windows(2) {
            let [mut from, to] = [pair[0], pair[1]];
            loop {
                let length = (to[0] - from[0]).hypot(to[1] - from[1]);
                if stroke.is_empty() && index % 2 == 0 {
                    stroke.push(from);
                }
                if length <= left {
                    left -= length;
                    if index % 2 == 0 {
                        stroke.push(to);
                    }
                    break;
                }
                let f = left / length;
                from = [from[0] + f * (to[0] - from[0]), from[1] + f * (to[1] - from[1])];
                if index % 2 == 0 {
                    stroke.push(from);
                    self.ops.push(Op::Line { points: std::mem::take(&mut stroke), color, width });
                }
                index += 1;
                left = dash[index % dash.len()];
            }
        }
        if stroke.len() > 1 {
            self.ops.push(Op::Line { points: stroke, color, width });
        }
    }

    /// A filled rectangle.
    pub fn rect(&mut self, low: [f64; 2], high: [f64; 2], color: Color) {
        self.ops.push(Op::Rect { low, high, color });
    }

    /// A disc or a circle.
    pub fn dot(&mut self, at: [f64; 2], radius: f64, color: Color, filled: bool) {
        self.ops.push(Op::Dot { at, radius, color, filled });
    }

    /// A text; `upwards` turns it by 90 degrees.
    pub fn text(&mut self, at: [f64; 2], text: &str, size: f64, anchor: Anchor, upwards: bool, color: Color) {
        if !text.is_empty() {
            self.ops.push(Op::Text { at, text: text.to_owned(), size, anchor, upwards, color });
        }
    }

    /// Writes `stem.png` and `stem.svg`.
    pub fn write(&self, stem: &Path) -> Result<()> {
        let (png, svg) = (self.png()?, self.svg()?);
        files::write(&stem.with_extension("png"), |file| Ok(file.write_all(&png)?))?;
        files::write(&stem.with_extension("svg"), |file| Ok(file.write_all(svg.as_bytes())?))
    }

    fn png(&self) -> Result<Vec<u8>> {
        let [width, height] = self.size;
        let (fine_width, fine_height) = (width * FINE, height * FINE);
        let mut fine = vec![255; (fine_width * fine_height * 3) as usize];
        let mut backend = BitMapBackend::with_buffer(&mut fine, (fine_width, fine_height));
        self.render(&mut backend, f64::from(FINE))?;
        drop(backend);
        let row = (fine_width * 3) as usize;
        let mut pixels = Vec::with_capacity((width * height * 3) as usize);
        for y in 0..height as usize {
            for x in 0..width as usize {
                for channel in 0..3 {
                    let mut sum = 0_u32;
                    for dy in 0..FINE as usize {
                        for dx in 0..FINE as usize {
                            sum += u32::from(
                                fine[(y * FINE as usize + dy) * row + (x * FINE as usize + dx) * 3 + channel],
                            );
                        }
                    }
                    pixels.push((sum / (FINE * FINE)) as u8);
                }
            }
        }
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.write_header()?.write_image_data(&pixels)?;
        Ok(bytes)
    }

    /// The picture as SVG.
    pub fn svg(&self) -> Result<String> {
        let [width, height] = self.size;
        let mut text = String::new();
        let mut backend = SVGBackend::with_string(&mut text, (width * FINE, height * FINE));
        self.render(&mut backend, f64::from(FINE))?;
        drop(backend);
        // Coordinates are whole numbers of a finer grid; the picture keeps its size.
        let fine = format!("width=\"{}\" height=\"{}\"", width * FINE, height * FINE);
        Ok(text.replacen(&fine, &format!("width=\"{width}\" height=\"{height}\""), 1))
    }

    fn render<B: DrawingBackend>(&self, backend: &mut B, scale: f64) -> Result<()> {
        static FONT: Once = Once::new();
        FONT.call_once(|| {
            // Fails only for bytes that are no font.
            let _ = register_font("sans-serif", FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT);
        });
        let failed = |error| anyhow!("drawing failed: {error}");
        let pixel = |[x, y]: [f64; 2]| ((x * scale).round() as i32, (y * scale).round() as i32);
        let [width, height] = self.size;
        let all = pixel([f64::from(width), f64::from(height)]);
        backend.draw_rect((0, 0), all, &RGBColor(255, 255, 255), true).map_err(failed)?;
        for op in &self.ops {
            match op {
                Op::Line { points, color, width } => {
                    let style = Pen { color: *color, width: (width * scale).round().max(1.0) as u32 };
                    let mut path: Vec<(i32, i32)> = points.iter().map(|&point| pixel(point)).collect();
                    path.dedup();
                    if path.len() > 1 {
                        backend.draw_path(path, &style).map_err(failed)?;
                    }
                }
                Op::Rect { low, high, color } => {
                    let (low, high) = (pixel(*low), pixel(*high));
                    let style = Pen { color: *color, width: 0 };
                    backend.draw_rect(low, high, &style, true).map_err(failed)?;
                }
                Op::Dot { at, radius, color, filled } => {
                    let style = Pen { color: *color, width: scale as u32 };
                    backend
                        .draw_circle(pixel(*at), (radius * scale).round() as u32, &style, *filled)
                        .map_err(failed)?;
                }
                Op::Text { at, text, size, anchor, upwards, color } => {
                    let [red, green, blue] = *color;
                    let color = RGBColor(red, green, blue);
                    let font = ("sans-serif", size * scale).into_font();
                    let font = if *upwards { font.transform(FontTransform::Rotate270) } else { font };
                    let across = match anchor {
                        Anchor::Start => HPos::Left,
                        Anchor::Middle => HPos::Center,
                        Anchor::End => HPos::Right,
                    };
                    let style = TextStyle::from(font).color(&color).pos(Pos::new(across, VPos::Center));
                    backend.draw_text(text, &style, pixel(*at)).map_err(failed)?;
                }
            }
        }
        backend.present().map_err(failed)
    }
}

struct Pen {
    color: Color,
    width: u32,
}

impl BackendStyle for Pen {
    fn color(&self) -> BackendColor {
        let [red, green, blue] = self.color;
        BackendColor { alpha: 1.0, rgb: (red, green, blue) }
    }

    fn stroke_width(&self) -> u32 {
        self.width
    }
}
