//! The state of the recursion in a checkpoint.

use super::{MAX_FIELDS, Pair, Products, QuasiNewton, fields_of};
use crate::checkpoint::{Damaged, Record};

impl QuasiNewton {
    /// Its state in a checkpoint.
    ///
    /// # Errors
    /// [`Damaged`] where not every field plays one part.
    pub fn record(&mut self, record: &mut Record<'_>) -> Result<(), Damaged> {
        let mut read = self.clone();
        let last = fields_of(self.most) - 1;
        [&mut read.scale, &mut read.norm, &mut read.slope]
            .into_iter()
            .try_for_each(|number| record.real(number))?;
        record.count(&mut read.direction, last)?;
        record.count(&mut read.preconditioned, last)?;
        let (mut pairs, mut free) = (read.pairs.len(), read.free.len());
        record.count(&mut pairs, self.most)?;
        record.count(&mut free, MAX_FIELDS)?;
        read.pairs.resize(pairs, Pair::default()).map_err(|_| Damaged)?;
        read.free.resize(free, 0).map_err(|_| Damaged)?;
        for (index, pair) in read.pairs.iter_mut().enumerate() {
            pair.record(record, index, last)?;
        }
        read.free
            .iter_mut()
            .try_for_each(|field| record.count(field, last))?;
        if !read.every_field_plays_one_part() {
            return Err(Damaged);
        }
        *self = read;
        Ok(())
    }

    fn every_field_plays_one_part(&self) -> bool {
        let parts = self
            .pair_fields()
            .chain(self.free.iter().copied())
            .chain([self.direction, self.preconditioned]);
        let (count, seen) = parts.fold((0, 0u32), |(count, seen), field| (count + 1, seen | 1 << field));
        let all = fields_of(self.most);
        (count, seen.count_ones() as usize) == (all, all)
    }
}

impl Pair {
    /// One after `older` pairs, of fields up to `last`.
    fn record(&mut self, record: &mut Record<'_>, older: usize, last: usize) -> Result<(), Damaged> {
        record.count(&mut self.s, last)?;
        record.count(&mut self.z, last)?;
        self.older
            .resize(older, Products::default())
            .map_err(|_| Damaged)?;
        for products in [&mut self.own, &mut self.gradient]
            .into_iter()
            .chain(&mut self.older)
        {
            record.real(&mut products.s)?;
            record.real(&mut products.z)?;
        }
        Ok(())
    }
}
