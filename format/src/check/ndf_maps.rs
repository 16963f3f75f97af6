//! Structural checks of the sections behind `ndf-maps`.

use super::Limited;
use crate::Container;
use crate::finding::{Fault, Finding};
use crate::model::NdfPixels;
use crate::records::{
    Instance, NDF_COPIES, NDF_GRID, NDF_NEIGHBOURS, NDF_PIXELS, NORMALS, NdfImage,
};
use crate::view::{Copied, MAX_NEIGHBOURS, NdfMaps};

/// Pixels that are not 0 are at least this: below are subnormal numbers.
const LEAST_PIXEL: u16 = 1 << 11;

/// Reports normals that are no points of the disk, images that are not where they should be, copies that cover nothing, and
/// neighbours and cells that name copies which are not there.
pub(super) fn check(
    container: &Container<'_>,
    instance: &Instance,
    report: &mut dyn FnMut(Finding),
) {
    let maps = match NdfMaps::open(container, instance) {
        Ok(maps) => maps,
        Err(finding) => return report(finding),
    };
    check_normals(&maps, instance, report);
    check_images(&maps, instance, report);
    check_grid(&maps, instance, report);
    check_copies(&maps, instance, report);
}

fn check_normals(maps: &NdfMaps<'_>, instance: &Instance, report: &mut dyn FnMut(Finding)) {
    let mut limited = Limited::new(report);
    for (place, normal) in (0..).zip(maps.normals) {
        let [s, t] = normal.point();
        // So that NaN is found.
        let is_on_disk = s * s + t * t <= 1.0;
        if !is_on_disk {
            let id = instance.section(NORMALS);
            limited.report(Finding::new(Fault::SurfaceNormal).within(id).at(place));
        }
    }
}

fn check_images(maps: &NdfMaps<'_>, instance: &Instance, report: &mut dyn FnMut(Finding)) {
    let pitch = maps.root.pitch.get();
    let is_image = |image: &NdfImage| {
        let [columns, rows] = image.size.map(|side| side.get());
        let reaches = |place: i32, side: u16| {
            let end = f64::from(place) + f64::from(side);
            f64::from(place) * pitch >= -2.0 - pitch && end * pitch <= 2.0 + 2.0 * pitch
        };
        let [x, y] = image.place.map(|place| place.get());
        columns > 0 && rows > 0 && reaches(x, columns) && reaches(y, rows)
    };
    let mut next = 0_u64;
    let mut limited = Limited::new(report);
    for (place, image) in (0..).zip(maps.images) {
        if u64::from(image.first.get()) != next || !is_image(image) {
            let finding = Finding::new(Fault::NdfImage).within(maps.id).at(place);
            limited.report(finding.values(next, u64::from(image.first.get())));
        }
        let [columns, rows] = image.size.map(|side| u64::from(side.get()));
        next = next.wrapping_add(columns.wrapping_mul(rows));
    }
    let id = instance.section(NDF_PIXELS);
    if next != maps.pixels.len() as u64 {
        let finding = Finding::new(Fault::SectionCount).within(id);
        limited.report(finding.values(next, maps.pixels.len() as u64));
    }
    let mut limited = Limited::new(report);
    for (place, pixel) in (0..).zip(maps.pixels) {
        if (1..LEAST_PIXEL).contains(&pixel.get()) {
            limited.report(Finding::new(Fault::NdfPixel).within(id).at(place));
        }
    }
    let is_whole = maps.layout.pixels == NdfPixels::Points;
    if is_whole
        && maps
            .images
            .iter()
            .any(|image| image.size[0] != image.size[1])
    {
        report(Finding::new(Fault::NdfImage).within(maps.id));
    }
}

fn check_grid(maps: &NdfMaps<'_>, instance: &Instance, report: &mut dyn FnMut(Finding)) {
    let mut last = 0;
    for (place, start) in (0..).zip(maps.grid) {
        let start = start.get();
        if start < last || (place == 0 && start != 0) {
            let id = instance.section(NDF_GRID);
            let finding = Finding::new(Fault::NdfGrid).within(id).at(place);
            return report(finding.values(u64::from(last), u64::from(start)));
        }
        last = start;
    }
    if maps.layout.is_scattered && last as usize != maps.copies.len() {
        let finding = Finding::new(Fault::NdfGrid).within(instance.section(NDF_GRID));
        report(finding.values(maps.copies.len() as u64, u64::from(last)));
    }
}

fn check_copies(maps: &NdfMaps<'_>, instance: &Instance, report: &mut dyn FnMut(Finding)) {
    let copies = instance.section(NDF_COPIES);
    let reach = maps.root.reach.get();
    let half = 0.5 * f64::from(maps.layout.example());
    let mut limited = Limited::new(report);
    for (number, copy) in maps.copies.iter().enumerate() {
        let is_sound = maps
            .copied(number)
            .is_some_and(|copied| covers(&copied, half, reach));
        if !is_sound || copy.reserved != [0; 2] {
            limited.report(
                Finding::new(Fault::NdfCopy)
                    .within(copies)
                    .at(number as u64),
            );
        }
    }
    let mut limited = Limited::new(report);
    let cells = maps.root.cells.get();
    for row in 0..cells {
        for column in 0..cells {
            for number in maps.copies_in(column, row) {
                let cell = maps.copies.get(number).map(|copy| {
                    // centre · cells / 2³²: less than the number of cells.
                    copy.centre
                        .map(|along| ((u64::from(along.get()) * u64::from(cells)) >> 32) as u32)
                });
                if cell != Some([column, row]) {
                    let finding = Finding::new(Fault::NdfCopy).within(copies);
                    limited.report(finding.at(number as u64));
                }
            }
        }
    }
    let id = instance.section(NDF_NEIGHBOURS);
    let mut limited = Limited::new(report);
    let mut last = 0_u64;
    for (number, copy) in (0..).zip(maps.copies) {
        let start = u64::from(copy.neighbours.get());
        let is_next = start >= last && start <= maps.neighbours.len() as u64;
        if !is_next || start.wrapping_sub(last) > MAX_NEIGHBOURS as u64 {
            let finding = Finding::new(Fault::NdfNeighbour).within(copies).at(number);
            limited.report(finding.values(last, start));
        }
        last = start;
    }
    for (place, neighbour) in (0..).zip(maps.neighbours) {
        if neighbour.get() as usize >= maps.copies.len() {
            let finding = Finding::new(Fault::NdfNeighbour).within(id).at(place);
            limited.report(finding.values(maps.copies.len() as u64, u64::from(neighbour.get())));
        }
    }
}

/// Whether a copy of an example of twice `half` texels covers something, and nothing farther from its centre than `reach`.
fn covers(copied: &Copied, half: f64, reach: f64) -> bool {
    let [[xx, xy], [yx, yy]] = copied.matrix;
    let determinant = (xx * yy - xy * yx).abs();
    let greatest = xx.abs().max(xy.abs()).max(yx.abs()).max(yy.abs());
    let square = |x: f64, y: f64| x * x + y * y;
    let corner = square(xx + xy, yx + yy).max(square(xx - xy, yx - yy)) * half * half;
    // Rounding of a transformation may take its corners a little farther.
    determinant >= 1e-4 * greatest * greatest && greatest > 0.0 && corner <= reach * reach * 1.001
}
