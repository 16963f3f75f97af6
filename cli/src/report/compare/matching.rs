//! Which part of one report is which of another.

use super::super::document::{MapReport, Report};
use super::super::table::printable;
use super::{Comparison, Missing};

/// Pairs of old and new that are the `same`, in the order of the new; the rest is `missing` by its `name`.
pub fn pair_up<T: Copy>(
    old: &[T],
    new: &[T],
    same: impl Fn(&T, &T) -> bool,
    name: impl Fn(&T) -> String,
    missing: &mut Vec<Missing>,
) -> Vec<(T, T)> {
    let mut is_paired = vec![false; old.len()];
    let mut pairs = Vec::new();
    // Both are mostly in the same order, so the search begins behind the last pair.
    let mut next = 0;
    for item in new {
        let found = (next..old.len())
            .chain(0..next.min(old.len()))
            .find(|&place| !is_paired[place] && same(&old[place], item));
        if let Some(place) = found {
            is_paired[place] = true;
            next = place + 1;
            pairs.push((old[place], *item));
        } else {
            missing.push(Missing {
                what: name(item),
                is_gone: false,
            });
        }
    }
    let gone = old
        .iter()
        .zip(is_paired)
        .filter(|(_, is_paired)| !is_paired);
    missing.extend(gone.map(|(item, _)| Missing {
        what: name(item),
        is_gone: true,
    }));
    pairs
}

/// Maps of the same name and content, then of what is left those of the same name, with a note.
pub fn maps<'r>(
    old: &'r Report,
    new: &'r Report,
    comparison: &mut Comparison,
) -> Vec<(&'r MapReport, &'r MapReport)> {
    let (old, new): (Vec<&MapReport>, Vec<&MapReport>) =
        (old.maps.iter().collect(), new.maps.iter().collect());
    let name = |map: &&MapReport| printable(&map.name);
    // What the first round misses, the second may find.
    let mut pairs = pair_up(
        &old,
        &new,
        |old, new| old.name == new.name && old.blake3 == new.blake3,
        name,
        &mut Vec::new(),
    );
    let left = |maps: &[&'r MapReport], paired: &[&'r MapReport]| -> Vec<&'r MapReport> {
        let is_paired = |map: &&&MapReport| paired.iter().any(|other| std::ptr::eq(*other, **map));
        maps.iter().filter(|map| !is_paired(map)).copied().collect()
    };
    let (olds, news): (Vec<&MapReport>, Vec<&MapReport>) = pairs.iter().copied().unzip();
    let by_name = pair_up(
        &left(&old, &olds),
        &left(&new, &news),
        |old, new| old.name == new.name,
        name,
        &mut comparison.missing,
    );
    for (_, map) in &by_name {
        let note = format!(
            "{}: the file has other content than before",
            printable(&map.name)
        );
        comparison.notes.push(note);
    }
    pairs.extend(by_name);
    pairs.sort_by_key(|(_, map)| new.iter().position(|other| std::ptr::eq(*other, *map)));
    pairs
}
