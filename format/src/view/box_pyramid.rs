//! Box pyramids: nested boxes of normals over the cells of a map.

use super::bin_tables::elements;
use crate::container::Container;
use crate::finding::{Fault, Finding};
use crate::model::{BoxPyramidLayout, PYRAMID_SIDE};
use crate::records::{BoxNode, Instance, PYRAMID_NODES, PYRAMID_ROOT, TileRoot};
use crate::section::SectionId;

/// Farthest a box may reach from the middle of the disk: curved lobes and overshooting interpolations leave it by 2.2.
const FARTHEST: f64 = 8.0;

/// A box of normals, and the unit of the boxes inside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PyramidBox {
    /// Least s and t.
    pub low: [f64; 2],
    /// A 255th of the sides.
    pub step: [f64; 2],
}

impl PyramidBox {
    /// The box of child `child` of `node`, whose own this is; `None` if there is no such child.
    #[inline]
    pub fn child(&self, node: &BoxNode, child: u32) -> Option<Self> {
        let byte = |bytes: &[u8; 16]| bytes.get(child as usize).copied().map(f64::from);
        let (low_s, high_s) = (byte(&node.low_s)?, byte(&node.high_s)?);
        let (low_t, high_t) = (byte(&node.low_t)?, byte(&node.high_t)?);
        (low_s <= high_s && low_t <= high_t).then(|| self.part([low_s, low_t], [high_s, high_t]))
    }

    /// The box from `low` to `high` 255ths of this one. What is encoded and what is decoded are the same operations.
    #[inline]
    pub fn part(&self, low: [f64; 2], high: [f64; 2]) -> Self {
        Self {
            low: [
                self.low[0] + low[0] * self.step[0],
                self.low[1] + low[1] * self.step[1],
            ],
            step: [
                (high[0] - low[0]) * self.step[0] / 255.0,
                (high[1] - low[1]) * self.step[1] / 255.0,
            ],
        }
    }

    /// Its sides.
    #[inline]
    pub fn extent(&self) -> [f64; 2] {
        self.step.map(|step| 255.0 * step)
    }
}

/// The box pyramid of one map.
#[derive(Clone, Copy, Debug)]
pub struct BoxPyramid<'a> {
    /// How cells nest.
    pub layout: BoxPyramidLayout,
    /// The section of nodes.
    pub id: SectionId,
    /// The box of all normals.
    pub root: PyramidBox,
    /// Nodes of all levels.
    pub nodes: &'a [BoxNode],
}

impl<'a> BoxPyramid<'a> {
    /// The pyramid stored with `instance` itself, or `None` if it stores none. O(1).
    ///
    /// # Errors
    /// If it has not as many nodes as the map's size says, or its root is no box.
    pub fn open(container: &Container<'a>, instance: &Instance) -> Result<Option<Self>, Finding> {
        let Some(layout) = instance.box_pyramid() else {
            return Ok(None);
        };
        let id = instance.section(PYRAMID_NODES);
        if container.find(id).is_none() {
            return Ok(None);
        }
        let nodes = elements(
            container,
            instance,
            PYRAMID_NODES,
            layout.node_count() as usize,
        )?;
        let root_id = instance.section(PYRAMID_ROOT);
        let root: &[TileRoot] = elements(container, instance, PYRAMID_ROOT, 1)?;
        let damaged = Finding::new(Fault::PyramidRoot).within(root_id);
        let root = root.first().ok_or(damaged)?;
        let [low, step] = [root.low, root.step].map(|pair| pair.map(|x| f64::from(x.get())));
        let is_low = |x: &f64| (-FARTHEST..=FARTHEST).contains(x);
        let is_step = |x: &f64| (0.0..=FARTHEST / 64.0).contains(x);
        if !low.iter().all(is_low) || !step.iter().all(is_step) {
            return Err(damaged);
        }
        Ok(Some(Self {
            layout,
            id,
            root: PyramidBox { low, step },
            nodes,
        }))
    }

    /// The pyramid of the map that `instance` was baked from: its own, or that of the first other instance of the same map,
    /// method and structure that stores one. O(instances).
    ///
    /// # Errors
    /// As [`open`](Self::open), and if no instance stores it.
    pub fn of_map(container: &Container<'a>, instance: &Instance) -> Result<Self, Finding> {
        super::of_map(container, instance, Self::open)?
            .ok_or(Finding::new(Fault::SectionMissing).within(instance.section(PYRAMID_NODES)))
    }

    /// The node in `column` and `row` of `level`.
    ///
    /// # Errors
    /// If it is not stored.
    #[inline]
    pub fn node(&self, level: u32, column: u32, row: u32) -> Result<&'a BoxNode, Finding> {
        self.nodes
            .get(self.layout.place(level, column, row))
            .ok_or_else(|| Finding::new(Fault::SectionCount).within(self.id))
    }

    /// Number and box of the block that holds the cell in `column` and `row`: the place of its node of level 1, which
    /// of the node's children it is, and its box of normals; `None` if there is none. O(levels).
    ///
    /// # Errors
    /// If a node is not stored.
    pub fn block_at(
        &self,
        column: u32,
        row: u32,
    ) -> Result<Option<(usize, u32, PyramidBox)>, Finding> {
        let mut bounds = self.root;
        let mut level = self.layout.top();
        loop {
            let shift = level.wrapping_add(1).wrapping_mul(2) & 31;
            let node = self.node(level, column >> shift, row >> shift)?;
            let finer = shift.wrapping_sub(2) & 31;
            let (x, y) = (
                (column >> finer) % PYRAMID_SIDE,
                (row >> finer) % PYRAMID_SIDE,
            );
            let child = PYRAMID_SIDE * y + x;
            let Some(inner) = bounds.child(node, child) else {
                return Ok(None);
            };
            bounds = inner;
            if level <= 1 {
                let place = self.layout.place(1, column >> 4, row >> 4);
                return Ok(Some((place, child, bounds)));
            }
            level = level.wrapping_sub(1);
        }
    }
}
