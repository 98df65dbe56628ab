//! The contact sheet: small copies of some pictures of a film side by side, each with a caption. Pure; pixels, +Y down.

use image::{
    DynamicImage, Rgb, RgbImage,
    imageops::{self, FilterType},
};

use super::lettering;

/// Pictures side by side, and rows of them.
const SIDE: usize = 4;
/// Width of one picture on the sheet, pixels.
const TILE_WIDTH: u32 = 480;
/// Pixels between two pictures.
const GAP: u32 = 6;
/// Pixels a dot of a caption's letter.
const LETTER_SCALE: u32 = 2;
/// Height of a caption below its picture, pixels.
const CAPTION: u32 = lettering::HEIGHT * LETTER_SCALE + 10;

const PAPER: Rgb<u8> = Rgb([24, 26, 30]);
const INK: Rgb<u8> = Rgb([226, 230, 236]);

/// Collects some pictures of a film that is `frame_count` long.
#[derive(Debug)]
pub struct ContactSheet {
    frame_count: usize,
    tiles: Vec<(usize, RgbImage, String)>,
}

impl ContactSheet {
    /// An empty sheet for a film of `frame_count` pictures.
    #[must_use]
    pub fn new(frame_count: usize) -> Self {
        Self { frame_count, tiles: Vec::new() }
    }

    /// Whether picture number `frame`, from 0, belongs on the sheet: first, last and evenly between.
    #[must_use]
    pub fn wants(&self, frame: usize) -> bool {
        let count = self.frame_count.min(SIDE * SIDE);
        let last = self.frame_count.saturating_sub(1);
        (0..count).any(|tile| tile * last / (count - 1).max(1) == frame)
    }

    /// Adds a small copy of picture number `frame`. Order does not matter.
    pub fn add(&mut self, frame: usize, picture: RgbImage, caption: String) {
        let height = (TILE_WIDTH * picture.height() / picture.width().max(1)).max(1);
        let tile = DynamicImage::from(picture).resize_exact(TILE_WIDTH, height, FilterType::Triangle);
        self.tiles.push((frame, tile.into_rgb8(), caption));
    }

    /// The sheet as one picture; `None` if nothing was added.
    #[must_use]
    pub fn compose(mut self) -> Option<RgbImage> {
        self.tiles.sort_by_key(|(frame, ..)| *frame);
        let tile_height = self.tiles.iter().map(|(_, tile, _)| tile.height()).max()?;
        let columns = self.tiles.len().min(SIDE);
        let rows = self.tiles.len().div_ceil(columns);
        let [columns_u, rows_u] = [columns, rows].map(|count| u32::try_from(count).unwrap_or(u32::MAX));
        let row_height = tile_height + CAPTION;
        let mut sheet =
            RgbImage::from_pixel(columns_u * (TILE_WIDTH + GAP) + GAP, rows_u * (row_height + GAP) + GAP, PAPER);
        for (place, (_, tile, caption)) in (0_u32..).zip(&self.tiles) {
            let left = GAP + place % columns_u * (TILE_WIDTH + GAP);
            let top = GAP + place / columns_u * (row_height + GAP);
            imageops::replace(&mut sheet, tile, left.into(), top.into());
            lettering::write(&mut sheet, caption, left + 4, top + tile_height + 5, LETTER_SCALE, INK);
        }
        Some(sheet)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_film_gives_sixteen_pictures_with_first_and_last() {
        let sheet = ContactSheet::new(600);
        let wanted: Vec<_> = (0..600).filter(|frame| sheet.wants(*frame)).collect();
        assert_eq!((wanted.len(), wanted[0], wanted[15]), (16, 0, 599), "wanted {wanted:?}");
    }

    #[test]
    fn a_short_film_gives_all_its_pictures() {
        for count in [1, 2, 7] {
            let sheet = ContactSheet::new(count);
            let wanted = (0..count).filter(|frame| sheet.wants(*frame)).count();
            assert_eq!(wanted, count, "{wanted} of {count} pictures");
        }
    }

    #[test]
    fn pictures_lie_in_order_whatever_order_they_came_in() {
        let mut sheet = ContactSheet::new(2);
        for (frame, shade) in [(1, 200), (0, 100)] {
            sheet.add(frame, RgbImage::from_pixel(96, 54, Rgb([shade; 3])), format!("{frame} s"));
        }
        let sheet = sheet.compose().unwrap();
        assert_eq!(sheet.dimensions(), (2 * (480 + GAP) + GAP, 270 + CAPTION + 2 * GAP));
        let middles = [GAP + 240, 2 * GAP + 480 + 240].map(|x| sheet.get_pixel(x, GAP + 135)[0]);
        assert_eq!(middles, [100, 200], "shades from left to right");
    }

    #[test]
    fn an_empty_sheet_is_no_picture() {
        assert!(ContactSheet::new(10).compose().is_none());
    }
}
