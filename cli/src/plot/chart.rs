//! Charts: curves, points and maps in a frame with axes and a legend; several of them side by side.

use super::axis::Axis;
use super::canvas::{Anchor, Canvas, Color};

/// Colours whose brightness differs, so that a grey print still tells them apart; curves also differ in dashes or marks.
pub const COLORS: [Color; 6] =
    [[20, 20, 20], [31, 78, 156], [200, 80, 45], [60, 160, 135], [225, 160, 35], [150, 185, 225]];
const INK: Color = [30, 30, 30];
const FAINT: Color = [225, 225, 225];

/// A mark at every point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Filled disc.
    Disc,
    /// Circle.
    Circle,
    /// Filled square.
    Square,
    /// x.
    Cross,
}

/// The marks in the order in which curves take them.
pub const MARKS: [Mark; 4] = [Mark::Disc, Mark::Circle, Mark::Square, Mark::Cross];

/// A curve, or points if `width` is 0.
#[derive(Clone, Debug)]
pub struct Curve {
    /// In the legend; none if empty.
    pub label: String,
    /// Where it goes; not-a-number breaks it.
    pub points: Vec<[f64; 2]>,
    /// Its colour.
    pub color: Color,
    /// Width of the line in pixels.
    pub width: f64,
    /// Strokes and gaps.
    pub dash: &'static [f64],
    /// At every point, with this radius.
    pub mark: Option<(Mark, f64)>,
}

/// A dashed line.
pub const DASHED: &[f64] = &[7.0, 5.0];
/// A dotted line.
pub const DOTTED: &[f64] = &[2.0, 4.0];
/// Dash, dot.
pub const DASH_DOT: &[f64] = &[9.0, 4.0, 2.0, 4.0];
/// Solid, then the others.
pub const DASHES: [&[f64]; 4] = [&[], DASHED, DASH_DOT, DOTTED];

impl Curve {
    /// A solid line.
    pub fn line(label: &str, points: Vec<[f64; 2]>, color: Color) -> Self {
        Self { label: label.to_owned(), points, color, width: 1.6, dash: &[], mark: None }
    }

    /// Points only.
    pub fn dots(label: &str, points: Vec<[f64; 2]>, color: Color, radius: f64) -> Self {
        Self { label: label.to_owned(), points, color, width: 0.0, dash: &[], mark: Some((Mark::Disc, radius)) }
    }
}

/// Values on a rectangular grid of cells, drawn as colours.
#[derive(Clone, Debug)]
pub struct Map {
    /// Cells along x and y.
    pub cells: [usize; 2],
    /// Row by row from the lowest y.
    pub values: Vec<f64>,
    /// The rectangle along x.
    pub x: [f64; 2],
    /// The rectangle along y.
    pub y: [f64; 2],
    /// The values of the first and the last colour.
    pub range: [f64; 2],
    /// Colours follow the logarithm.
    pub log: bool,
    /// Beside the bar of colours.
    pub label: String,
}

/// One frame.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Above it.
    pub title: String,
    /// Below it.
    pub x_label: String,
    /// At its left.
    pub y_label: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// A unit is as long on both axes.
    pub equal: bool,
    /// Beneath the curves.
    pub map: Option<Map>,
    /// The curves, later ones on top.
    pub curves: Vec<Curve>,
    /// Words at places of the plane.
    pub notes: Vec<([f64; 2], String)>,
    /// Whether there are axes at all.
    pub frame: bool,
}

impl Chart {
    /// An empty chart.
    pub fn new(title: &str, x_label: &str, y_label: &str, x: Axis, y: Axis) -> Self {
        Self {
            title: title.to_owned(),
            x_label: x_label.to_owned(),
            y_label: y_label.to_owned(),
            x,
            y,
            equal: false,
            map: None,
            curves: Vec::new(),
            notes: Vec::new(),
            frame: true,
        }
    }
}

/// Charts side by side, `columns` in a row, under a common title.
pub fn sheet(title: &str, charts: &[Chart], columns: usize, width: u32, height: u32) -> Canvas {
    let columns = columns.clamp(1, charts.len().max(1));
    let rows = charts.len().div_ceil(columns);
    let top = if title.is_empty() { 0 } else { 44 };
    let mut canvas = Canvas::new(width * columns as u32, height * rows as u32 + top);
    if !title.is_empty() {
        let middle = f64::from(width) * columns as f64 / 2.0;
        // A long title is set smaller rather than cut.
        let size = (f64::from(width) * columns as f64 * 1.75 / title.chars().count() as f64).clamp(9.0, 19.0);
        canvas.text([middle, 24.0], title, size, Anchor::Middle, false, INK);
    }
    for (index, chart) in charts.iter().enumerate() {
        let x = f64::from(width) * (index % columns) as f64;
        let y = f64::from(height) * (index / columns) as f64 + f64::from(top);
        draw(&mut canvas, chart, [x, y], [f64::from(width), f64::from(height)]);
    }
    canvas
}

struct Frame {
    low: [f64; 2],
    high: [f64; 2],
    x: Axis,
    y: Axis,
}

impl Frame {
    fn pixel(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            self.low[0] + self.x.place(x) * (self.high[0] - self.low[0]),
            self.high[1] - self.y.place(y) * (self.high[1] - self.low[1]),
        ]
    }

    fn holds(&self, [x, y]: [f64; 2]) -> bool {
        x >= self.low[0] - 0.5 && x <= self.high[0] + 0.5 && y >= self.low[1] - 0.5 && y <= self.high[1] + 0.5
    }

    /// The part of a segment inside the frame: Liang & Barsky, 1984.
    fn clip(&self, a: [f64; 2], b: [f64; 2]) -> Option<([f64; 2], [f64; 2])> {
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for axis in 0..2 {
            let step = b[axis] - a[axis];
            for (p, q) in [(-step, a[axis] - self.low[axis]), (step, self.high[axis] - a[axis])] {
                if p == 0.0 {
                    if q < 0.0 {
                        return None;
                    }
                } else if p < 0.0 {
                    from = from.max(q / p);
                } else {
                    to = to.min(q / p);
                }
            }
        }
        let at = |f: f64| [a[0] + f * (b[0] - a[0]), a[1] + f * (b[1] - a[1])];
        (from <= to).then(|| (at(from), at(to)))
    }
}

fn draw(canvas: &mut Canvas, chart: &Chart, origin: [f64; 2], size: [f64; 2]) {
    let bar = if chart.map.is_some() { 92.0 } else { 0.0 };
    let (top, bottom) = (origin[1] + if chart.title.is_empty() { 16.0 } else { 38.0 }, origin[1] + size[1] - 58.0);
    let longest = chart.y.ticks(wanted(bottom - top, TALL)).0.iter().map(|(_, label)| width(label)).fold(0.0, f64::max);
    let mut low = [origin[0] + (longest + 38.0).max(78.0), top];
    let mut high = [origin[0] + size[0] - 22.0 - bar, bottom];
    if chart.equal {
        let spans = [chart.x.high - chart.x.low, chart.y.high - chart.y.low];
        let unit = ((high[0] - low[0]) / spans[0]).min((high[1] - low[1]) / spans[1]);
        for axis in 0..2 {
            let room = high[axis] - low[axis] - unit * spans[axis];
            low[axis] += room / 2.0;
            high[axis] -= room / 2.0;
        }
    }
    let frame = Frame { low, high, x: chart.x, y: chart.y };
    let middle = [(low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0];
    let title_size = ((size[0] - 20.0) * 1.85 / chart.title.chars().count().max(1) as f64).clamp(9.0, 16.0);
    canvas.text([middle[0], low[1] - 18.0], &chart.title, title_size, Anchor::Middle, false, INK);
    if let Some(map) = &chart.map {
        draw_map(canvas, map, &frame);
    }
    if chart.frame {
        axes(canvas, chart, &frame, origin[0] + size[0]);
    }
    for curve in &chart.curves {
        draw_curve(canvas, curve, &frame);
    }
    for (place, words) in &chart.notes {
        canvas.text(frame.pixel(*place), words, 14.0, Anchor::Middle, false, INK);
    }
    if chart.frame {
        let corners = [low, [high[0], low[1]], high, [low[0], high[1]], low];
        canvas.line(&corners, INK, 1.0, &[]);
    }
    legend(canvas, chart, &frame);
}

/// Width of a letter over the height of its font, on average.
const LETTER: f64 = 0.53;
/// Height of the numbers on axes.
const NUMBERS: f64 = 14.0;

/// Pixels from one tick to the next, about, along x and along y.
const WIDE: f64 = 75.0;
/// See [`WIDE`].
const TALL: f64 = 55.0;

/// How many ticks an axis of so many pixels has.
fn wanted(pixels: f64, each: f64) -> usize {
    ((pixels / each) as usize).clamp(2, 8)
}

/// About how wide a number at a tick is.
fn width(label: &str) -> f64 {
    LETTER * NUMBERS * label.chars().count() as f64
}

/// The ticks whose labels leave one another room; both ends stay. `place` is along the axis, `extent` a label's length there.
fn fitting(labels: Vec<(f64, String)>, place: impl Fn(f64) -> f64, extent: impl Fn(&str) -> f64) -> Vec<(f64, String)> {
    let apart = |a: &(f64, String), b: &(f64, String)| {
        (place(a.0) - place(b.0)).abs() >= (extent(&a.1) + extent(&b.1)) / 2.0 + 6.0
    };
    let Some((last, rest)) = labels.split_last() else { return labels };
    let mut kept: Vec<(f64, String)> = Vec::with_capacity(labels.len());
    for label in rest {
        if kept.last().is_none_or(|before| apart(before, label) && apart(label, last)) {
            kept.push(label.clone());
        }
    }
    kept.push(last.clone());
    kept
}

fn axes(canvas: &mut Canvas, chart: &Chart, frame: &Frame, right: f64) {
    let (low, high) = (frame.low, frame.high);
    let grid = chart.map.is_none();
    let (labels, minor) = chart.x.ticks(wanted(high[0] - low[0], WIDE));
    let at = |value: f64| frame.pixel([value, chart.y.low])[0];
    for (value, label) in fitting(labels, at, width) {
        let x = at(value);
        if grid {
            canvas.line(&[[x, low[1]], [x, high[1]]], FAINT, 0.7, &[]);
        }
        canvas.line(&[[x, high[1]], [x, high[1] + 5.0]], INK, 1.0, &[]);
        // The last label stays within the picture.
        let middle = x.min(right - width(&label) / 2.0);
        canvas.text([middle, high[1] + 16.0], &label, NUMBERS, Anchor::Middle, false, INK);
    }
    for value in minor {
        let x = at(value);
        canvas.line(&[[x, high[1]], [x, high[1] + 3.0]], INK, 0.7, &[]);
    }
    let (labels, minor) = chart.y.ticks(wanted(high[1] - low[1], TALL));
    let at = |value: f64| frame.pixel([chart.x.low, value])[1];
    let mut widest = 0.0_f64;
    for (value, label) in fitting(labels, at, |_| NUMBERS) {
        let y = at(value);
        if grid {
            canvas.line(&[[low[0], y], [high[0], y]], FAINT, 0.7, &[]);
        }
        canvas.line(&[[low[0] - 5.0, y], [low[0], y]], INK, 1.0, &[]);
        canvas.text([low[0] - 9.0, y], &label, NUMBERS, Anchor::End, false, INK);
        widest = widest.max(width(&label));
    }
    for value in minor {
        let y = at(value);
        canvas.line(&[[low[0] - 3.0, y], [low[0], y]], INK, 0.7, &[]);
    }
    let middle = [(low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0];
    canvas.text([middle[0], high[1] + 40.0], &chart.x_label, 15.0, Anchor::Middle, false, INK);
    let left = low[0] - 26.0 - widest;
    canvas.text([left, middle[1]], &chart.y_label, 15.0, Anchor::Middle, true, INK);
}

fn draw_curve(canvas: &mut Canvas, curve: &Curve, frame: &Frame) {
    let points: Vec<[f64; 2]> = curve.points.iter().map(|&point| frame.pixel(point)).collect();
    if curve.width > 0.0 {
        let mut run: Vec<[f64; 2]> = Vec::new();
        for pair in points.windows(2) {
            let finite = pair.iter().flatten().all(|x| x.is_finite());
            let Some((a, b)) = finite.then(|| frame.clip(pair[0], pair[1])).flatten() else {
                canvas.line(&run, curve.color, curve.width, curve.dash);
                run.clear();
                continue;
            };
            if run.last() != Some(&a) {
                canvas.line(&run, curve.color, curve.width, curve.dash);
                run = vec![a];
            }
            run.push(b);
        }
        canvas.line(&run, curve.color, curve.width, curve.dash);
    }
    if let Some((mark, radius)) = curve.mark {
        for &point in points.iter().filter(|point| point.iter().all(|x| x.is_finite()) && frame.holds(**point)) {
            draw_mark(canvas, mark, point, radius, curve.color);
        }
    }
}

fn draw_mark(canvas: &mut Canvas, mark: Mark, [x, y]: [f64; 2], r: f64, color: Color) {
    match mark {
        Mark::Disc => canvas.dot([x, y], r, color, true),
        Mark::Circle => {
            canvas.dot([x, y], r, [255, 255, 255], true);
            canvas.dot([x, y], r, color, false);
        }
        Mark::Square => canvas.rect([x - r, y - r], [x + r, y + r], color),
        Mark::Cross => {
            canvas.line(&[[x - r, y - r], [x + r, y + r]], color, 1.5, &[]);
            canvas.line(&[[x - r, y + r], [x + r, y - r]], color, 1.5, &[]);
        }
    }
}

fn legend(canvas: &mut Canvas, chart: &Chart, frame: &Frame) {
    let entries: Vec<&Curve> = chart.curves.iter().filter(|curve| !curve.label.is_empty()).collect();
    if entries.is_empty() {
        return;
    }
    let longest = entries.iter().map(|curve| curve.label.chars().count()).max().unwrap_or(0);
    let size = [52.0 + 7.4 * longest as f64, 12.0 + 20.0 * entries.len() as f64];
    let room = 10.0;
    // At the top, at the bottom, between; at the right, at the left, in the middle.
    let along = |axis: usize, share: f64| {
        frame.low[axis] + room + share * (frame.high[axis] - frame.low[axis] - size[axis] - 2.0 * room)
    };
    let corners =
        [0.0, 1.0, 0.5, 0.25, 0.75].into_iter().flat_map(|y| [1.0, 0.0, 0.5].map(|x| [along(0, x), along(1, y)]));
    // The place that hides the least: points, and samples along the segments between them.
    let hidden = |corner: &[f64; 2]| {
        let inside = |p: [f64; 2]| {
            p[0] > corner[0] && p[0] < corner[0] + size[0] && p[1] > corner[1] && p[1] < corner[1] + size[1]
        };
        let mut count = 0;
        for curve in &chart.curves {
            let points: Vec<[f64; 2]> = curve.points.iter().map(|&point| frame.pixel(point)).collect();
            count += points.iter().filter(|&&point| inside(point)).count();
            if curve.width > 0.0 {
                for pair in points.windows(2) {
                    let between = (1..8).map(|i| f64::from(i) / 8.0);
                    count += between
                        .filter(|f| {
                            inside([
                                pair[0][0] + f * (pair[1][0] - pair[0][0]),
                                pair[0][1] + f * (pair[1][1] - pair[0][1]),
                            ])
                        })
                        .count();
                }
            }
        }
        count
    };
    let Some(corner) = corners.min_by_key(hidden) else { return };
    let far = [corner[0] + size[0], corner[1] + size[1]];
    canvas.rect(corner, far, [255, 255, 255]);
    canvas.line(&[corner, [far[0], corner[1]], far, [corner[0], far[1]], corner], [190, 190, 190], 0.7, &[]);
    for (index, curve) in entries.iter().enumerate() {
        let y = corner[1] + 16.0 + 20.0 * index as f64;
        let (from, to) = (corner[0] + 8.0, corner[0] + 38.0);
        if curve.width > 0.0 {
            canvas.line(&[[from, y], [to, y]], curve.color, curve.width.max(1.4), curve.dash);
        }
        if let Some((mark, radius)) = curve.mark {
            draw_mark(canvas, mark, [(from + to) / 2.0, y], radius.max(3.0), curve.color);
        }
        canvas.text([corner[0] + 45.0, y], &curve.label, 14.0, Anchor::Start, false, INK);
    }
}

/// Viridis at eleven places (Smith & van der Walt, 2015; public domain): brightness grows along it, so grey prints read.
const VIRIDIS: [Color; 11] = [
    [68, 1, 84],
    [72, 36, 117],
    [65, 68, 135],
    [53, 95, 141],
    [42, 120, 142],
    [33, 145, 140],
    [34, 168, 132],
    [68, 191, 112],
    [122, 209, 81],
    [189, 223, 38],
    [253, 231, 37],
];

/// The colour at `f` from 0 to 1, in 64 levels so that equal neighbours can be drawn as one.
fn shade(f: f64) -> Color {
    let f = (f.clamp(0.0, 1.0) * 63.0).round() / 63.0 * 10.0;
    let index = (f.floor() as usize).min(9);
    let part = f - index as f64;
    let mix = |a: u8, b: u8| (f64::from(a) + part * (f64::from(b) - f64::from(a))).round() as u8;
    let (a, b) = (VIRIDIS[index], VIRIDIS[index + 1]);
    [mix(a[0], b[0]), mix(a[1], b[1]), mix(a[2], b[2])]
}

fn draw_map(canvas: &mut Canvas, map: &Map, frame: &Frame) {
    let [nx, ny] = map.cells;
    let [bottom, top] = map.range;
    let color = |value: f64| {
        let f = if map.log {
            (value.max(bottom) / bottom).ln() / (top / bottom).ln()
        } else {
            (value - bottom) / (top - bottom)
        };
        shade(if f.is_finite() { f } else { 0.0 })
    };
    let clamp = |p: [f64; 2]| [p[0].clamp(frame.low[0], frame.high[0]), p[1].clamp(frame.low[1], frame.high[1])];
    let corner = |i: usize, j: usize| {
        let x = map.x[0] + (map.x[1] - map.x[0]) * i as f64 / nx as f64;
        let y = map.y[0] + (map.y[1] - map.y[0]) * j as f64 / ny as f64;
        clamp(frame.pixel([x, y]))
    };
    for (j, row) in map.values.chunks_exact(nx).enumerate() {
        let mut start = 0;
        while start < nx {
            let here = color(row[start]);
            let mut end = start + 1;
            while end < nx && color(row[end]) == here {
                end += 1;
            }
            let (a, b) = (corner(start, j), corner(end, j + 1));
            if (b[0] - a[0]) * (a[1] - b[1]) > 0.0 {
                canvas.rect([a[0], b[1]], [b[0], a[1]], here);
            }
            start = end;
        }
    }
    // The bar of colours, with the axis of its values.
    let (left, right) = (frame.high[0] + 16.0, frame.high[0] + 30.0);
    let height = frame.high[1] - frame.low[1];
    for level in 0..64 {
        let y = frame.high[1] - height * f64::from(level + 1) / 64.0;
        canvas.rect([left, y], [right, y + height / 64.0 + 0.4], shade(f64::from(level) / 63.0));
    }
    let axis = Axis { low: bottom, high: top, log: map.log };
    let at = |value: f64| frame.high[1] - axis.place(value) * height;
    for (value, label) in fitting(axis.ticks(((height / 60.0) as usize).clamp(2, 6)).0, at, |_| 13.0) {
        let y = at(value);
        canvas.line(&[[right, y], [right + 4.0, y]], INK, 1.0, &[]);
        canvas.text([right + 7.0, y], &label, 13.0, Anchor::Start, false, INK);
    }
    canvas.text([(left + right) / 2.0 + 14.0, frame.low[1] - 12.0], &map.label, 14.0, Anchor::Middle, false, INK);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sheet_is_written_whole() {
        let wave = |phase: f64| {
            (0..200).map(|i| [f64::from(i) / 20.0, (f64::from(i) / 20.0 + phase).sin()]).collect::<Vec<_>>()
        };
        let mut chart = Chart::new("Waves", "time t", "height u", Axis::fixed([0.0, 10.0]), Axis::fixed([-1.2, 1.2]));
        for i in 0..6 {
            let mut curve = Curve::line(&format!("phase {i}"), wave(0.2 * i as f64), COLORS[i]);
            curve.dash = DASHES[i % 4];
            chart.curves.push(curve);
        }
        let line: Vec<[f64; 2]> =
            (0..5).map(|i| [0.04 / 2_f64.powf(f64::from(i) / 2.0), 1e-3 / 2_f64.powf(f64::from(i) * 1.8)]).collect();
        let (x, y) = (Axis::around(line.iter().map(|p| p[0]), true), Axis::around(line.iter().map(|p| p[1]), true));
        let mut errors = Chart::new("Errors", "spacing h", "L1 error", x, y);
        errors.curves.push(Curve { mark: Some((Mark::Square, 4.0)), ..Curve::line("positions", line, COLORS[1]) });
        let values: Vec<f64> = (0..400).map(|i| f64::from(i % 20) * f64::from(i / 20)).collect();
        let mut map = Chart::new("Map", "x", "y", Axis::fixed([-1.0, 1.0]), Axis::fixed([-1.0, 1.0]));
        map.equal = true;
        map.map = Some(Map {
            cells: [20, 20],
            values,
            x: [-1.0, 1.0],
            y: [-1.0, 1.0],
            range: [0.0, 361.0],
            log: false,
            label: "\u{3c1}".to_owned(),
        });
        let canvas = sheet("A sheet", &[chart, errors, map], 2, 520, 400);
        let stem = std::env::temp_dir().join(format!("mollis-sheet-{}", std::process::id()));
        canvas.write(&stem).unwrap();
        let png = std::fs::read(stem.with_extension("png")).unwrap();
        let svg = std::fs::read_to_string(stem.with_extension("svg")).unwrap();
        assert!(png.starts_with(b"\x89PNG") && png.len() > 10_000, "{}", png.len());
        for text in ["A sheet", "phase 5", "spacing h", "width=\"1040\""] {
            assert!(svg.contains(text), "{text}");
        }
        if std::env::var_os("MOLLIS_KEEP_PICTURES").is_none() {
            std::fs::remove_file(stem.with_extension("png")).unwrap();
            std::fs::remove_file(stem.with_extension("svg")).unwrap();
        }
    }
}
