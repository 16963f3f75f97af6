//! Rows of a report that compare: one map, kernel, surface, filter and roughness at a time.

use super::document::{Cell, Contestant, HalfVectors, MapReport, PackageReport, Row};
use super::pareto;
use super::units::{self, EXACT};
use crate::measure::subject::surface_name;
use glintbake_format::model::Interpolation;

/// The rows of a map that were asked with one kernel, surface, filter and roughness.
#[derive(Clone, Debug)]
pub struct Panel<'r> {
    /// The map.
    pub map: &'r MapReport,
    /// Kernel, surface, filter and roughness of every row.
    key: Key<'r>,
    /// Who answered, in the order of their first rows.
    pub contestants: Vec<&'r Contestant>,
    /// The rows, in the order of the report.
    pub rows: Vec<&'r Row>,
}

/// What the rows of a panel have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Key<'r> {
    kernel: &'r str,
    surface: &'r str,
    filter: &'r str,
    roughness: Option<f64>,
}

impl<'r> Key<'r> {
    fn of(row: &'r Row) -> Self {
        Self {
            kernel: &row.kernel,
            surface: &row.surface,
            filter: &row.cell.filter,
            roughness: row.cell.roughness,
        }
    }
}

/// Every panel of `map`, in the order of their first rows.
pub fn panels(map: &MapReport) -> Vec<Panel<'_>> {
    let mut panels: Vec<Panel<'_>> = Vec::new();
    for row in &map.rows {
        let key = Key::of(row);
        let place = panels.iter().position(|panel| panel.key == key);
        let place = place.unwrap_or_else(|| {
            panels.push(Panel {
                map,
                key,
                contestants: Vec::new(),
                rows: Vec::new(),
            });
            panels.len() - 1
        });
        let panel = &mut panels[place];
        if !panel.contestants.contains(&&row.contestant) {
            panel.contestants.push(&row.contestant);
        }
        panel.rows.push(row);
    }
    panels
}

impl<'r> Panel<'r> {
    /// Kernel, surface if it is not that of texels, filter and roughness in words, such as `disk kernel, linear surface, gaussian,
    /// α = 0.01`.
    pub fn title(&self) -> String {
        let Key {
            kernel,
            surface,
            filter,
            roughness,
        } = self.key;
        let mut title = format!("{kernel} kernel, ");
        if surface != surface_name(Interpolation::None) {
            title += &format!("{surface} surface, ");
        }
        title += filter;
        if let Some(roughness) = roughness {
            title += &format!(", α = {}", units::plain(roughness));
        }
        title
    }

    /// Sizes σ of the cells of `anisotropy` with half vectors found by the truth, rising.
    pub fn sizes(&self, anisotropy: f64) -> Vec<f64> {
        let found = self.rows.iter().map(|row| &row.cell).filter(|cell| {
            cell.anisotropy == anisotropy && cell.half_vectors == HalfVectors::Found
        });
        sorted(found.map(|cell| cell.sigma))
    }

    /// Every anisotropy of the panel, rising.
    pub fn anisotropies(&self) -> Vec<f64> {
        sorted(self.rows.iter().map(|row| row.cell.anisotropy))
    }

    /// What `contestant` answered under footprints of size `sigma` to half vectors found by the truth.
    pub fn found(&self, contestant: &Contestant, sigma: f64, anisotropy: f64) -> Option<&'r Row> {
        self.rows.iter().copied().find(|row| {
            let Cell {
                sigma: size,
                anisotropy: length,
                half_vectors,
                ..
            } = row.cell;
            row.contestant == *contestant
                && size == sigma
                && length == anisotropy
                && half_vectors == HalfVectors::Found
        })
    }

    /// What `contestant` takes: its package for the panel's roughness, or the one for any.
    pub fn package(&self, contestant: &Contestant) -> Option<&'r PackageReport> {
        package(self.map, contestant, self.key.roughness)
    }

    /// Indices among the contestants of those on the front of error against time at size `sigma`, fastest first.
    pub fn front(&self, sigma: f64, anisotropy: f64) -> Vec<usize> {
        let points: Vec<[f64; 2]> = self
            .contestants
            .iter()
            .map(|contestant| {
                self.found(contestant, sigma, anisotropy)
                    .and_then(|row| Some([row.times.eval.median_ns, shown(row.truth.relative_l1?)]))
                    .unwrap_or([f64::NAN; 2])
            })
            .collect();
        pareto::front(&points)
    }
}

/// `error`, or 0 below what is shown as none.
pub fn shown(error: f64) -> f64 {
    if error < EXACT { 0.0 } else { error }
}

/// What `contestant` takes on `map`: its package for `roughness`, or the one for any.
pub fn package<'r>(
    map: &'r MapReport,
    contestant: &Contestant,
    roughness: Option<f64>,
) -> Option<&'r PackageReport> {
    map.packages.iter().find(|package| {
        package.contestant == *contestant
            && (package.roughness.is_none() || package.roughness == roughness)
    })
}

/// The different ones of `values`, rising.
pub fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

#[cfg(test)]
mod tests {
    use super::super::fixtures;
    use super::*;

    #[test]
    fn rows_of_different_kernels_filters_and_roughnesses_are_apart() {
        let report = fixtures::report();
        let map = &report.maps[0];
        let panels = panels(map);
        let titles: Vec<String> = panels.iter().map(Panel::title).collect();
        assert_eq!(
            titles,
            [
                "beckmann kernel, box, α = 0.01",
                "disk kernel, box, α = 0.01",
                "beckmann kernel, box, α = 0.04",
                "disk kernel, box, α = 0.04",
                "bin-average kernel, box",
            ]
        );
        assert_eq!(
            panels.iter().map(|panel| panel.rows.len()).sum::<usize>(),
            map.rows.len()
        );
        assert_eq!(panels[0].sizes(1.0), fixtures::SIZES);
        assert_eq!(panels[0].anisotropies(), [1.0, 8.0]);
    }

    #[test]
    fn rows_of_different_surfaces_are_apart() {
        let mut report = fixtures::report();
        let rows = &mut report.maps[0].rows;
        rows.retain(|row| row.kernel == "disk" && row.cell.roughness == Some(0.01));
        for row in rows
            .iter_mut()
            .filter(|row| row.contestant.method == "lean")
        {
            row.surface = "linear".to_owned();
        }
        let panels = panels(&report.maps[0]);
        let titles: Vec<String> = panels.iter().map(Panel::title).collect();
        assert_eq!(
            titles,
            [
                "disk kernel, linear surface, box, α = 0.01",
                "disk kernel, box, α = 0.01"
            ]
        );
        assert_eq!(panels[0].contestants.len(), 2);
    }

    #[test]
    fn tiny_errors_do_not_keep_slow_contestants_on_the_front() {
        let mut report = fixtures::report();
        for row in &mut report.maps[0].rows {
            row.truth.relative_l1 = Some(1e-9);
        }
        let panels = panels(&report.maps[0]);
        assert_eq!(panels[0].front(4.0, 1.0).len(), 1);
    }
}
