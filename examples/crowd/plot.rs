//! The plot: frames of each crowd over time, and what a frame is made of. SVG.

use core::error::Error;

use plotters::{
    coord::Shift,
    prelude::{
        BLACK, ChartBuilder, Color, DrawingArea, IntoDrawingArea, IntoFont, LineSeries, PathElement, RGBColor,
        Rectangle, SVGBackend, SeriesLabelPosition, Text, WHITE,
    },
};

use super::{
    flags::Way,
    meter::PARTS,
    report::{Row, part_name},
};

type Failure = Box<dyn Error>;
type Panel<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Width and height, pixels.
const SIZE: (u32, u32) = (1000, 900);
const GRID: RGBColor = RGBColor(225, 225, 225);
/// Of the parts of a frame.
const COLOURS: [RGBColor; PARTS.len()] = [
    RGBColor(90, 60, 150),
    RGBColor(200, 80, 20),
    RGBColor(230, 170, 60),
    RGBColor(60, 140, 90),
    RGBColor(70, 160, 190),
    RGBColor(50, 90, 170),
    RGBColor(170, 175, 180),
];

fn colour(way: Way) -> RGBColor {
    match way {
        Way::Surefoot => RGBColor(200, 80, 20),
        Way::Poses => RGBColor(230, 170, 60),
        Way::Levels => RGBColor(70, 140, 90),
        Way::BuiltIn => RGBColor(60, 90, 160),
    }
}

/// The figure as SVG text.
pub(crate) fn figure(rows: &[Row]) -> Result<String, Failure> {
    let mut text = String::new();
    draw(&SVGBackend::with_string(&mut text, SIZE).into_drawing_area(), rows)?;
    Ok(text)
}

fn draw(area: &Panel<'_>, rows: &[Row]) -> Result<(), Failure> {
    area.fill(&WHITE)?;
    let (top, bottom) = area.split_vertically(430);
    let most = rows.iter().map(|row| row.count).max().unwrap_or(0);
    over_time(&top, rows.iter().filter(|row| row.count == most), most)?;
    parts(&bottom, rows)?;
    Ok(area.present()?)
}

fn over_time<'a>(panel: &Panel<'_>, rows: impl Iterator<Item = &'a Row> + Clone, count: usize) -> Result<(), Failure> {
    let frames = rows.clone().map(|row| row.frames.len()).max().unwrap_or(1).max(2);
    let most = rows.clone().flat_map(|row| row.frames.iter().copied()).fold(1.0, f64::max);
    let mut chart = ChartBuilder::on(panel)
        .caption(format!("frame time of {count} characters"), ("sans-serif", 22).into_font().color(&BLACK))
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(70)
        .build_cartesian_2d(0..frames - 1, 0.0..1.1 * most)?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .bold_line_style(GRID)
        .label_style(("sans-serif", 16))
        .x_desc("frame")
        .y_desc("ms")
        .draw()?;
    for row in rows {
        let points = row.frames.iter().copied().enumerate();
        let line = colour(row.way).stroke_width(2);
        let name = format!("{}: median {:.1} ms", row.way.name(), row.frame);
        chart
            .draw_series(LineSeries::new(points, line))?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], line));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerRight)
        .label_font(("sans-serif", 16))
        .background_style(WHITE.mix(0.8))
        .draw()?;
    Ok(())
}

/// One bar a crowd, its parts side by side.
fn parts(panel: &Panel<'_>, rows: &[Row]) -> Result<(), Failure> {
    let panel = panel.titled("what a frame is made of, ms", ("sans-serif", 22))?;
    let (width, height) = panel.dim_in_pixel();
    let (left, right, legend) = (150, 90, 40);
    let most = rows.iter().map(|row| row.parts.iter().sum::<f64>()).fold(1e-3, f64::max);
    let scale = f64::from(width - left - right) / most;
    let step = (height - legend) as i32 / rows.len().max(1) as i32;
    let font = ("sans-serif", 16).into_font().color(&BLACK);
    for (index, row) in rows.iter().enumerate() {
        let y = index as i32 * step;
        let mut x = f64::from(left);
        let middle = y + step / 2 - 8;
        panel.draw(&Text::new(format!("{} {}", row.count, row.way.name()), (12, middle), font.clone()))?;
        for (part, fill) in row.parts.iter().zip(COLOURS) {
            let end = x + part * scale;
            panel.draw(&Rectangle::new([(x as i32, y + step / 5), (end as i32, y + 4 * step / 5)], fill.filled()))?;
            x = end;
        }
        panel.draw(&Text::new(format!("{:.1}", row.frame), (x as i32 + 6, middle), font.clone()))?;
    }
    for (part, fill) in COLOURS.iter().enumerate() {
        let (x, y) = (left as i32 + 110 * part as i32, height as i32 - 28);
        panel.draw(&Rectangle::new([(x, y), (x + 14, y + 14)], fill.filled()))?;
        panel.draw(&Text::new(part_name(part), (x + 20, y), font.clone()))?;
    }
    Ok(())
}
