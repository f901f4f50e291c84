//! Tiles that are drawn and have one sample a pixel: most of that is shaded plainly.

use glam::DVec2;

use super::{BATCH, Desk, Painter, Stop};
use crate::picture::Rect;
use crate::picture::pixel::Pixel;
use crate::picture::plain::Rows;
use crate::scan::Shadows;

impl Painter<'_> {
    /// Draws and shades a rectangle that has one sample a pixel into rows of its own.
    pub(super) fn run_plain_apart(&mut self, rect: Rect, shadows: &Shadows) -> Result<(), Stop> {
        let (width, height) = (rect.width as usize, rect.height as usize);
        let mut colors = std::mem::take(&mut self.desk.plain.colors);
        colors.resize(width * height, [0.0; 4]);
        let result = self.run_plain(rect, shadows, &mut Rows::new(&mut colors, width, 0));
        self.desk.plain.colors = colors;
        result
    }

    /// Draws and shades a rectangle that has one sample a pixel; what is not shaded plainly goes the way of all others.
    pub(super) fn run_plain(&mut self, rect: Rect, shadows: &Shadows, rows: &mut Rows<'_>) -> Result<(), Stop> {
        self.draw(rect, 0, &[DVec2::ZERO])?;
        let Desk { frame, plain, counts, .. } = &mut self.desk;
        plain.shadow_count = 0;
        plain.shade(frame, rows, &self.setting, shadows);
        let others = std::mem::take(&mut plain.others);
        counts.camera += u64::from(rect.width) * u64::from(rect.height) - others.len() as u64;
        counts.shadow += plain.shadow_count;
        self.begin_batch();
        for batch in others.chunks(BATCH) {
            self.desk.pixels.clear();
            for (slot, (column, row)) in batch.iter().enumerate() {
                self.desk.pixels.push(Pixel::new((rect.x + column, rect.y + row)));
                self.add_ray(slot as u32, 0, DVec2::ZERO);
            }
            self.flush()?;
            for (pixel, (column, row)) in self.desk.pixels.iter().zip(batch) {
                rows.put(*column, *row, pixel.color());
            }
        }
        self.desk.plain.others = others;
        Ok(())
    }

    /// Finds what the layers show of what was drawn and shaded plainly.
    pub(super) fn keep_plain_centres(&mut self, places: impl Iterator<Item = (u32, u32)>) -> Result<(), Stop> {
        self.desk.pixels.clear();
        self.desk.active.clear();
        if self.setting.view.layers {
            self.desk.pixels.extend(places.map(Pixel::new));
            self.desk.active.extend(0..self.desk.pixels.len() as u32);
            self.desk.centres.resize(self.desk.pixels.len(), None);
            let counts = self.desk.counts;
            self.look_through_centres()?;
            // These samples were counted when they were shaded.
            self.desk.counts = counts;
        }
        Ok(())
    }
}
