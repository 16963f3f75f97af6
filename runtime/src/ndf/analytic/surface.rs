//! The surface itself: normals at any place, and those of the vertices of cells.

use crate::error::QueryError;
use glintbake_format::model::{CATMULL_ROM, CATMULL_ROM_PARTS, Interpolation, Wrap};
use glintbake_format::view::Normals;
use glintbake_format::{Fault, Finding};

/// Vertices along a side of a cell in 4 × 4 parts.
pub(super) const VERTICES: usize = CATMULL_ROM_PARTS + 1;

/// Normals of a map and how they continue.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface<'a> {
    pub normals: Normals<'a>,
    pub wrap: Wrap,
    pub interpolation: Interpolation,
}

impl Surface<'_> {
    /// Where cell (0, 0) begins, in texels: cells are texels where nothing is interpolated, else squares between middles.
    pub fn shift(&self) -> f64 {
        match self.interpolation {
            Interpolation::None => 0.0,
            Interpolation::Linear | Interpolation::CatmullRom => 0.5,
        }
    }

    /// The normal of texel (`x`, `y`), wherever it lies.
    ///
    /// # Errors
    /// [`QueryError::Damaged`].
    #[inline]
    pub fn texel(&self, x: i64, y: i64) -> Result<[f64; 2], QueryError> {
        let [width, height] = self.normals.size;
        let fold = |place: i64, side: u32| {
            let side = i64::from(side);
            if (0..side).contains(&place) {
                place
            } else {
                match self.wrap {
                    Wrap::Repeat => place.checked_rem_euclid(side).unwrap_or(0),
                    Wrap::Clamp => place.clamp(0, side.saturating_sub(1)),
                }
            }
        };
        let (column, row) = (fold(x, width) as u32, fold(y, height) as u32);
        self.normals
            .normal(column, row)
            .ok_or_else(|| self.damaged())
    }

    fn damaged(&self) -> QueryError {
        Finding::new(Fault::SectionCount)
            .within(self.normals.id)
            .into()
    }

    /// The 16 texels around cell (`x`, `y`), row by row, from one before it on.
    ///
    /// # Errors
    /// [`QueryError::Damaged`].
    pub fn around(&self, x: i64, y: i64) -> Result<[[[f64; 2]; 4]; 4], QueryError> {
        let mut texels = [[[0.0; 2]; 4]; 4];
        for (row, line) in (-1..3).zip(&mut texels) {
            for (column, texel) in (-1..3).zip(line) {
                *texel = self.texel(x.wrapping_add(column), y.wrapping_add(row))?;
            }
        }
        Ok(texels)
    }

    /// The normal at (`x`, `y`) in texels: of the same triangles that integrals are over.
    ///
    /// # Errors
    /// [`QueryError::Damaged`].
    pub fn at(&self, [x, y]: [f64; 2]) -> Result<[f64; 2], QueryError> {
        let shift = self.shift();
        let (x, y) = (x - shift, y - shift);
        let (column, row) = (libm::floor(x), libm::floor(y));
        let (across, down) = (x - column, y - row);
        let (column, row) = (column as i64, row as i64);
        match self.interpolation {
            Interpolation::None => self.texel(column, row),
            Interpolation::Linear => {
                let (right, below) = (column.wrapping_add(1), row.wrapping_add(1));
                let corners = [
                    [self.texel(column, row)?, self.texel(right, row)?],
                    [self.texel(column, below)?, self.texel(right, below)?],
                ];
                Ok(on_triangles(corners, across, down))
            }
            Interpolation::CatmullRom => {
                let texels = self.around(column, row)?;
                let parts = CATMULL_ROM_PARTS as f64;
                let (across, down) = (parts * across, parts * down);
                let part = |place: f64| libm::floor(place).clamp(0.0, parts - 1.0);
                let (i, j) = (part(across), part(down));
                let vertex = |i: f64, j: f64| bicubic(&texels, i as usize, j as usize);
                let corners = [
                    [vertex(i, j), vertex(i + 1.0, j)],
                    [vertex(i, j + 1.0), vertex(i + 1.0, j + 1.0)],
                ];
                Ok(on_triangles(corners, across - i, down - j))
            }
        }
    }
}

/// The normal at (`across`, `down`) of a square of two triangles, cut from the upper right to the lower left corner.
fn on_triangles([[a, b], [c, d]]: [[[f64; 2]; 2]; 2], across: f64, down: f64) -> [f64; 2] {
    let on_axis = |a: f64, b: f64, c: f64, d: f64| {
        if across + down <= 1.0 {
            a + across * (b - a) + down * (c - a)
        } else {
            d + (1.0 - across) * (c - d) + (1.0 - down) * (b - d)
        }
    };
    [
        on_axis(a[0], b[0], c[0], d[0]),
        on_axis(a[1], b[1], c[1], d[1]),
    ]
}

/// Texels in a row weighed by `weights`.
#[inline(always)]
fn weighed(weights: &[f64; 4], texels: &[[f64; 2]; 4]) -> [f64; 2] {
    let [v, w, x, y] = weights;
    let [a, b, c, d] = texels;
    [
        (v * a[0] + w * b[0]) + (x * c[0] + y * d[0]),
        (v * a[1] + w * b[1]) + (x * c[1] + y * d[1]),
    ]
}

/// The normal of vertex (`i`, `j`) of the cell in the middle of `texels`.
fn bicubic(texels: &[[[f64; 2]; 4]; 4], i: usize, j: usize) -> [f64; 2] {
    let weights = |place: usize| CATMULL_ROM.get(place).unwrap_or(&[0.0; 4]);
    let columns = texels.each_ref().map(|row| weighed(weights(i), row));
    weighed(weights(j), &columns)
}

/// The normals of all vertices of the cell in the middle of `texels`, row by row.
#[inline]
pub(super) fn vertices(texels: &[[[f64; 2]; 4]; 4]) -> [[[f64; 2]; VERTICES]; VERTICES] {
    // Rows first, then for each row of vertices the columns.
    let rows = CATMULL_ROM.map(|weights| texels.each_ref().map(|row| weighed(&weights, row)));
    CATMULL_ROM.map(|weights| rows.each_ref().map(|column| weighed(&weights, column)))
}

/// The normals of the vertices along a line of four texels, of which the middle two are its ends.
pub(super) fn along(texels: &[[f64; 2]; 4]) -> [[f64; 2]; VERTICES] {
    CATMULL_ROM.map(|weights| weighed(&weights, texels))
}
