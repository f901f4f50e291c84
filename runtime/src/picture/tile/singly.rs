//! Tiles that are traced with one sample a pixel: their colours are put where they belong, batch by batch.

use glam::DVec2;

use super::{BATCH, Key, Painter, Stop, through};
use crate::picture::Rect;
use crate::picture::plain::Rows;

impl Painter<'_> {
    /// Traces and shades a rectangle into rows of its own.
    pub(super) fn run_singly(&mut self, rect: Rect) -> Result<(), Stop> {
        self.desk.pixels.clear();
        self.desk.centres.clear();
        let (width, height) = (rect.width as usize, rect.height as usize);
        let mut colors = std::mem::take(&mut self.desk.plain.colors);
        colors.resize(width * height, [0.0; 4]);
        let result = self.fill(rect, &mut Rows::new(&mut colors, width, 0));
        self.desk.plain.colors = colors;
        result
    }

    fn fill(&mut self, rect: Rect, rows: &mut Rows<'_>) -> Result<(), Stop> {
        let order = std::mem::take(&mut self.desk.order);
        let inside = order.iter().filter(|(dx, dy)| *dx < rect.width && *dy < rect.height);
        let filled = self.fill_at(rect, inside, rows);
        self.desk.order = order;
        filled
    }

    /// Fills in the pixels at these places of a rectangle.
    fn fill_at<'p>(
        &mut self,
        rect: Rect,
        mut places: impl Iterator<Item = &'p (u32, u32)>,
        rows: &mut Rows<'_>,
    ) -> Result<(), Stop> {
        loop {
            self.begin_batch();
            for (column, row) in places.by_ref().take(BATCH) {
                let pixel = (rect.x + column, rect.y + row);
                self.desk.keys.push(Key { slot: 0, pixel, sample: 0 });
                self.desk.points.push(through(pixel, DVec2::ZERO));
            }
            if self.desk.keys.is_empty() {
                return Ok(());
            }
            let by_columns = self.shade()?;
            for (key, color) in self.desk.keys.iter().zip(self.desk.scratch.colors(by_columns)) {
                rows.put(key.pixel.0 - rect.x, key.pixel.1 - rect.y, *color);
            }
        }
    }
}
