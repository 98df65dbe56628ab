//! One figure of a row: feet, ground, plants and pelvis over time, as SVG. Pure.

use core::{error::Error, ops::Range};

use plotters::{
    coord::{Shift, types::RangedCoordf32},
    prelude::{
        AreaSeries, BLACK, Cartesian2d, ChartBuilder, ChartContext, Color, DrawingArea, IntoDrawingArea, IntoFont,
        LineSeries, RGBColor, Rectangle, SVGBackend, WHITE,
    },
};

use crate::{
    measure::frame::Frame,
    testing::gauntlet::{Feet, Row},
};

/// Width and height of a figure, pixels.
const SIZE: (u32, u32) = (1000, 900);
const PELVIS: RGBColor = RGBColor(90, 60, 150);
const FOOT: RGBColor = RGBColor(200, 80, 20);
const SOLE: RGBColor = RGBColor(235, 180, 140);
const GROUND: RGBColor = RGBColor(110, 120, 100);
const EARTH: RGBColor = RGBColor(214, 218, 205);
const PLANT: RGBColor = RGBColor(214, 230, 250);
const GRID: RGBColor = RGBColor(225, 225, 225);

type Panel<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Failure = Box<dyn Error>;

/// Name of the figure's file, such as `stairs-up_walk_ik.svg`.
pub(super) fn file_name(row: &Row) -> String {
    let plain = |text: &str| {
        let dashed: String = text.chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect();
        dashed.split('-').filter(|word| !word.is_empty()).collect::<Vec<_>>().join("-")
    };
    format!("{}_{}_{}.svg", plain(&row.world), plain(&row.tape), words(row).0)
}

/// What moved the joints, for names of files and for titles.
fn words(row: &Row) -> (&'static str, &'static str) {
    match row.feet {
        Feet::Placed => ("ik", "feet placed by IK"),
        Feet::AsClips => ("clip", "feet as the clips have them"),
        Feet::BuiltIn => ("bevy", "Bevy's own animation player"),
    }
}

/// The figure as SVG text.
pub(super) fn figure(row: &Row) -> Result<String, Failure> {
    let mut text = String::new();
    draw(&SVGBackend::with_string(&mut text, SIZE).into_drawing_area(), row)?;
    Ok(text)
}

fn draw(area: &Panel<'_>, row: &Row) -> Result<(), Failure> {
    area.fill(&WHITE)?;
    let title = format!("{}, {}: {}", row.world, row.tape, words(row).1);
    let (top, bottom) = area.titled(&title, ("sans-serif", 28))?.split_vertically(260);
    pelvis(&top, &row.frames)?;
    for (side, panel) in bottom.split_evenly((2, 1)).iter().enumerate() {
        foot(panel, side, &row.frames)?;
    }
    Ok(area.present()?)
}

/// Over the root, as the feet, so that stairs and hills don't hide what moves.
fn pelvis(panel: &Panel<'_>, frames: &[Frame]) -> Result<(), Failure> {
    let points: Vec<(f32, f32)> = frames.iter().map(|frame| (frame.time, frame.pelvis - frame.root.y)).collect();
    let heights = range(points.iter().map(|point| point.1), 0.02);
    let mut chart = chart(panel, "pelvis", times(frames), heights)?;
    chart.draw_series(LineSeries::new(points, PELVIS.stroke_width(2)))?;
    Ok(())
}

fn foot(panel: &Panel<'_>, side: usize, frames: &[Frame]) -> Result<(), Failure> {
    // Each point by itself: on a slope the lowest of the sole is another in every frame.
    let height = |point: usize| {
        let above_root = move |frame: &Frame| (frame.time, frame.feet[side].sole[point].y - frame.root.y);
        frames.iter().map(above_root).collect::<Vec<_>>()
    };
    let (heel, ball, tip) = (height(0), height(1), height(2));
    let under_ball = |frame: &Frame| Some((frame.time, frame.feet[side].ground[1]? - frame.root.y));
    let ground: Vec<_> = frames.iter().filter_map(under_ball).collect();
    let heights = range([&ground, &heel, &ball, &tip].into_iter().flatten().map(|point| point.1), 0.03);
    let name = ["left", "right"][side];
    let caption =
        format!("{name} foot: ball (orange) over its ground (grey), heel and toes (pale); blue while it stands");
    let mut chart = chart(panel, &caption, times(frames), heights.clone())?;
    let shade = |&(from, to): &(f32, f32)| Rectangle::new([(from, heights.start), (to, heights.end)], PLANT.filled());
    chart.draw_series(stances(frames, side).iter().map(shade))?;
    chart.draw_series(AreaSeries::new(ground.clone(), heights.start, EARTH))?;
    chart.draw_series(LineSeries::new(ground, GROUND.stroke_width(1)))?;
    for end in [heel, tip] {
        chart.draw_series(LineSeries::new(end, SOLE.stroke_width(1)))?;
    }
    chart.draw_series(LineSeries::new(ball, FOOT.stroke_width(2)))?;
    Ok(())
}

type Chart<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<RangedCoordf32, RangedCoordf32>>;

/// Axes with a caption, seconds by metres.
fn chart<'a>(panel: &Panel<'a>, caption: &str, times: Range<f32>, heights: Range<f32>) -> Result<Chart<'a>, Failure> {
    let style = ("sans-serif", 20).into_font().color(&BLACK);
    let mut chart = ChartBuilder::on(panel)
        .caption(caption, style)
        .margin(8)
        .x_label_area_size(40)
        .y_label_area_size(64)
        .build_cartesian_2d(times, heights)?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .bold_line_style(GRID)
        .label_style(("sans-serif", 16))
        .axis_desc_style(("sans-serif", 18))
        .x_label_formatter(&|time| format!("{time:.1}"))
        .y_label_formatter(&|height| format!("{height:.2}").replace("-0.00", "0.00"))
        .x_desc("time, s")
        .y_desc("height over the root, m")
        .draw()?;
    Ok(chart)
}

fn times(frames: &[Frame]) -> Range<f32> {
    0.0..frames.last().map_or(1.0, |frame| frame.time)
}

/// From the least to the largest value, at least 10 cm, with `margin` on both sides.
fn range(values: impl Iterator<Item = f32>, margin: f32) -> Range<f32> {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f32::MAX, f32::MIN), |(low, high), value| (low.min(value), high.max(value)));
    if low > high {
        return 0.0..1.0;
    }
    let spare = margin + (0.05 - 0.5 * (high - low)).max(0.0);
    low - spare..high + spare
}

/// When the foot stands: from and to, seconds.
fn stances(frames: &[Frame], side: usize) -> Vec<(f32, f32)> {
    let mut spans: Vec<(f32, f32)> = Vec::new();
    let mut last = None;
    for frame in frames {
        if frame.feet[side].stance {
            match spans.last_mut() {
                Some(span) if last == Some(true) => span.1 = frame.time,
                _ => spans.push((frame.time, frame.time)),
            }
        }
        last = Some(frame.feet[side].stance);
    }
    spans
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::{bars::Bars, summary::Measures};

    fn row() -> Row {
        let frame = |index: usize| {
            let mut frame = Frame { time: index as f32 / 60.0, ..Frame::default() };
            frame.feet[0].stance = (20..40).contains(&index);
            frame.feet.iter_mut().for_each(|foot| foot.ground = [Some(0.0); 3]);
            frame
        };
        Row {
            world: "ramp 10°".to_owned(),
            tape: "walk, run, walk".to_owned(),
            feet: Feet::Placed,
            measures: Measures::default(),
            bars: Bars::default(),
            breaches: Vec::new(),
            frames: (0..60).map(frame).collect(),
        }
    }

    #[test]
    fn a_figure_names_its_row_and_the_units_of_its_axes() {
        let row = row();
        let figure = figure(&row).unwrap();
        for text in
            ["<svg", "ramp 10°, walk, run, walk", "time, s", "height over the root, m", "left foot", "right foot"]
        {
            assert!(figure.contains(text), "no `{text}` in the figure");
        }
        assert_eq!(file_name(&row), "ramp-10_walk-run-walk_ik.svg");
    }

    #[test]
    fn a_stance_is_one_span() {
        let spans = stances(&row().frames, 0);
        assert_eq!(spans.len(), 1, "{spans:?}");
        assert!((spans[0].0 - 20.0 / 60.0).abs() < 1e-4 && (spans[0].1 - 39.0 / 60.0).abs() < 1e-4, "{spans:?}");
    }

    #[test]
    fn a_row_without_frames_still_makes_a_figure() {
        assert!(figure(&Row { frames: Vec::new(), ..row() }).is_ok());
    }
}
