//! Where points of a plot are on its figure, for a page that lays something over them.

use super::svg::Point;
use super::{Content, Figure, Legend};

impl Figure {
    /// The places of points on the figure as shares of its width and height, for a figure of a single plot without heading whose legend is
    /// hidden; `None` for a point that the plot does not show, and for all points of another figure.
    ///
    /// ```
    /// use granum_report::figure::{Axis, Figure, Legend, Panel, Plot};
    ///
    /// let plot = Plot::new(Axis::new("x").between(0.0, 1.0), Axis::new("y").between(0.0, 1.0));
    /// let figure = Figure::new("nothing", 1, vec![Panel::plot(plot)]).legend(Legend::Hidden);
    /// let [a, b] = figure.places(&[[0.0, 0.0], [1.0, 1.0]])[..] else { panic!() };
    /// let (Some([left, low]), Some([right, high])) = (a, b) else { panic!() };
    /// assert!(0.0 < left && left < right && right < 1.0 && 0.0 < high && high < low && low < 1.0);
    /// ```
    pub fn places(&self, points: &[Point]) -> Vec<Option<Point>> {
        let mut figure = self.clone();
        figure.share_units();
        figure.width /= self.enlargement();
        figure.row_height /= self.enlargement();
        let frames = figure.frames();
        let is_plain = figure.legend == Legend::Hidden && figure.heading.is_empty();
        let ([panel], [frame], true) = (&figure.panels[..], &frames[..], is_plain) else {
            return vec![None; points.len()];
        };
        let Content::Plot(plot) = &panel.content else { return vec![None; points.len()] };
        let [x, y] = plot.laid(frame);
        let size = [figure.width, figure.height()];
        let place = |point: &Point| Some([x.at(point[0])? / size[0], y.at(point[1])? / size[1]]);
        points.iter().map(place).collect()
    }
}
