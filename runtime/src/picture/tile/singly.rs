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
        let filled = if rect.width == self.desk.side && rect.height == self.desk.side {
            self.fill_at(rect, &order, rows)
        } else {
            // At the edge of the picture.
            let inside = order.iter().copied().filter(|(dx, dy)| *dx < rect.width && *dy < rect.height);
            self.fill_at(rect, &inside.collect::<Vec<_>>(), rows)
        };
        self.desk.order = order;
        filled
    }

    /// Fills in the pixels at these places of a rectangle.
    fn fill_at(&mut self, rect: Rect, places: &[(u32, u32)], rows: &mut Rows<'_>) -> Result<(), Stop> {
        for places in places.chunks(BATCH) {
            self.begin_batch();
            let pixel = |(column, row): &(u32, u32)| (rect.x + column, rect.y + row);
            self.desk.keys.extend(places.iter().map(|it| Key { slot: 0, pixel: pixel(it), sample: 0 }));
            self.desk.points.extend(places.iter().map(|it| through(pixel(it), DVec2::ZERO)));
            let by_columns = self.shade()?;
            for ((column, row), color) in places.iter().zip(self.desk.scratch.colors(by_columns)) {
                rows.put(*column, *row, *color);
            }
        }
        Ok(())
    }
}
