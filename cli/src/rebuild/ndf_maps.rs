//! The surface that copies of an example make up.

use glintbake_bake::normals::NormalMap;
use glintbake_bake::oracle::ndf_maps::Surface;
use glintbake_format::model::Wrap;
use glintbake_format::records::Structure;
use glintbake_format::view::{Copied, NdfMaps};
use glintbake_format::{Container, Fault, Finding};
use glintbake_runtime::Instance;

/// The example of `instance`, and the copies of it that are stored, for the oracle.
///
/// # Errors
/// If sections are missing or damaged.
pub fn surface(container: &Container<'_>, instance: &Instance) -> Result<Surface, Finding> {
    let maps = NdfMaps::open(container, instance)?;
    let damaged = Finding::new(Fault::NdfCopy).within(maps.id);
    let copies: Option<Vec<Copied>> = (0..maps.copies.len())
        .map(|number| maps.copied(number))
        .collect();
    let side = maps.layout.example();
    let texels = maps
        .normals
        .iter()
        .map(|normal| normal.point().map(|x| x as f32));
    Ok(Surface {
        example: NormalMap::new(side, side, instance.wrap, texels.collect()),
        size: maps.layout.size,
        copies: copies.ok_or(damaged)?,
        is_scattered: maps.layout.is_scattered,
        scales_slopes: maps.layout.scales_slopes,
        ground: maps.root.ground.map(|x| x.get()),
        ground_deviation: maps.root.ground_deviation.get(),
    })
}

/// The example, if the surface is nothing but copies of it as it is.
pub(super) fn plain(
    container: &Container<'_>,
    instance: &Instance,
) -> Result<Option<Vec<[f32; 2]>>, Finding> {
    let Structure::NdfMaps(layout) = instance.structure else {
        return Ok(None);
    };
    if layout.is_scattered || layout.size != layout.example() {
        return Ok(None);
    }
    let surface = surface(container, instance)?;
    let is_plain = surface.copies[0].matrix == [[1.0, 0.0], [0.0, 1.0]];
    Ok(is_plain.then(|| surface.example.texels().to_vec()))
}

/// The normals of one tile of texture space at `size` × `size` points: those of the copy whose centre is nearest of all that cover a
/// point, interpolated between texels, or the ground's.
///
/// # Errors
/// If sections are missing or damaged.
pub fn explicit(
    container: &Container<'_>,
    instance: &Instance,
    size: u32,
) -> Result<NormalMap, Finding> {
    let surface = surface(container, instance)?;
    let scale = f64::from(surface.size) / f64::from(size);
    let half = 0.5 * f64::from(surface.example.width());
    let ground = surface.ground.map(|x| x as f32);
    let count = size as usize * size as usize;
    let mut texels = vec![ground; count];
    let mut nearest = vec![f64::INFINITY; count];
    for (number, copy) in surface.copies.iter().enumerate() {
        let [[xx, xy], [yx, yy]] = copy.matrix;
        let determinant = xx * yy - xy * yx;
        let reach = [xx.abs() + xy.abs(), yx.abs() + yy.abs()].map(|sum| half * sum);
        let range = |axis: usize| {
            if !surface.is_scattered {
                return 0..i64::from(size);
            }
            let first = ((copy.centre[axis] - reach[axis]) / scale - 0.5).ceil() as i64;
            let last = ((copy.centre[axis] + reach[axis]) / scale - 0.5).floor() as i64;
            first..last + 1
        };
        for row in range(1) {
            for column in range(0) {
                let from = [column, row].map(|at| (at as f64 + 0.5) * scale);
                let [x, y] = [from[0] - copy.centre[0], from[1] - copy.centre[1]];
                let place = [
                    half + (yy * x - xy * y) / determinant,
                    half + (xx * y - yx * x) / determinant,
                ];
                let is_within = place.iter().all(|at| (0.0..=2.0 * half).contains(at));
                if surface.is_scattered && !is_within {
                    continue;
                }
                let [column, row] = [column, row].map(|at| at.rem_euclid(i64::from(size)) as usize);
                let texel = row * size as usize + column;
                let squared = x * x + y * y;
                if squared < nearest[texel] {
                    nearest[texel] = squared;
                    let normal = surface.shown(number, interpolated(&surface.example, place));
                    texels[texel] = normal.map(|x| x as f32);
                }
            }
        }
    }
    Ok(NormalMap::new(size, size, Wrap::Repeat, texels))
}

/// The normal at `place` of the example, in texels, linear between the middles of texels.
fn interpolated(example: &NormalMap, place: [f64; 2]) -> [f64; 2] {
    let side = i64::from(example.width());
    let fold = |index: i64| match example.wrap() {
        Wrap::Repeat => index.rem_euclid(side),
        Wrap::Clamp => index.clamp(0, side - 1),
    };
    let normal = |x: i64, y: i64| example.texels()[(fold(y) * side + fold(x)) as usize];
    let [x, y] = place.map(|at| at - 0.5);
    let (column, row) = (x.floor(), y.floor());
    let (across, down) = (x - column, y - row);
    let (column, row) = (column as i64, row as i64);
    [0, 1].map(|axis: usize| {
        let read = |x: i64, y: i64| f64::from(normal(x, y)[axis]);
        let upper = read(column, row) * (1.0 - across) + read(column + 1, row) * across;
        let lower = read(column, row + 1) * (1.0 - across) + read(column + 1, row + 1) * across;
        upper * (1.0 - down) + lower * down
    })
}
