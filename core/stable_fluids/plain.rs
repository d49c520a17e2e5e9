//! Fields without ghosts, in and out of padded ones.

use super::cells::Cells;
use crate::field::rows;
use crate::real::Real;

impl Cells {
    /// Adds a field without ghosts times `unit` to a padded one.
    pub fn add<T: Real>(&self, given: &[T], unit: f64, field: &mut [T]) {
        let given = given.chunks_exact(self.n[0].max(1));
        for (row, given) in (0..self.rows()).zip(given) {
            if let Some(out) = field.get_mut(self.row(row)) {
                rows::add_scaled(out, T::from_f64(unit), given);
            }
        }
    }

    /// Copies the cells of a padded field into one without ghosts.
    pub fn pack<T: Real>(&self, padded: &[T], out: &mut [T]) {
        for (row, out) in out.chunks_exact_mut(self.n[0].max(1)).enumerate() {
            if let Some(row) = padded.get(self.row(row)) {
                out.copy_from_slice(row);
            }
        }
    }

    /// Copies a field without ghosts into the cells of a padded one.
    pub fn unpack<T: Real>(&self, field: &[T], padded: &mut [T]) {
        for (row, field) in field.chunks_exact(self.n[0].max(1)).enumerate() {
            if let Some(out) = padded.get_mut(self.row(row)) {
                out.copy_from_slice(field);
            }
        }
    }
}
