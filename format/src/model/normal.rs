//! Directions as points of the projected disk.

/// A half vector as a point of the projected unit disk: `h = (s, t, sqrt(1 - s² - t²))`.
///
/// `s` points right and `t` up in the picture of the map (OpenGL, glTF green), so `t` runs against `v`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfVector {
    /// Right, in [-1, 1].
    pub s: f64,
    /// Up, in [-1, 1].
    pub t: f64,
}

impl HalfVector {
    /// The half vector with the first two components of the unit vector `direction`.
    pub const fn from_direction(direction: [f64; 3]) -> Self {
        Self {
            s: direction[0],
            t: direction[1],
        }
    }

    /// Whether the point lies in the closed unit disk, that is, names a direction of the hemisphere.
    pub fn is_on_disk(self) -> bool {
        self.s * self.s + self.t * self.t <= 1.0
    }

    /// The unit direction; beyond the disk, the nearest direction on the horizon.
    pub fn direction(self) -> [f64; 3] {
        let squared = self.s * self.s + self.t * self.t;
        if squared <= 1.0 {
            [self.s, self.t, libm::sqrt(1.0 - squared)]
        } else {
            let length = libm::sqrt(squared);
            [self.s / length, self.t / length, 0.0]
        }
    }
}
