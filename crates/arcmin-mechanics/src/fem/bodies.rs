//! Carrier and housing of a machine condensed to their seats, and stored as bytes.

use sha2::{Digest, Sha256};

use super::{CacheError, CarrierShape, Compliance, FemError, HousingShape};
use crate::machine::{Hold, Machine};
use crate::materials::Material;
use crate::progress::{Counter, Progress};

/// Elastic carrier and housing.
#[derive(Debug, Clone, PartialEq)]
pub struct ElasticBodies {
    /// [`CarrierShape::compliance`], relative to the output face.
    pub carrier: Compliance,
    /// [`HousingShape::compliance`], relative to the support of the flange.
    pub housing: Compliance,
}

/// The solids of a machine from which [`ElasticBodies`] are computed.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyShapes {
    /// Plates and pillars of the carrier.
    pub carrier: CarrierShape,
    /// Housing with pin grooves and flange.
    pub housing: HousingShape,
}

const MAGIC: &[u8; 8] = b"arcminEB";
/// Version; to be increased whenever meshes, loads or this layout change the results.
const FORMAT: u64 = 6;

impl BodyShapes {
    /// Both solids of a machine, with their meshes' usual sizes.
    pub fn of(machine: &Machine) -> BodyShapes {
        BodyShapes { carrier: CarrierShape::of(machine), housing: HousingShape::of(machine) }
    }

    /// Meshes, factorises and condenses both bodies.
    ///
    /// # Errors
    /// [`FemError`] if dimensions contradict each other.
    pub fn reduce(&self, progress: &dyn Progress) -> Result<ElasticBodies, FemError> {
        let done = Counter::new("condensing carrier and housing", 2, progress);
        let (carrier, housing) = rayon::join(
            || done.after(|| self.carrier.compliance()),
            || done.after(|| self.housing.compliance()),
        );
        Ok(ElasticBodies { carrier: carrier?, housing: housing? })
    }

    /// SHA-256 of everything the reduction depends on: equal keys, equal results.
    pub fn key(&self) -> [u8; 32] {
        let mut hash = Sha256::new();
        let mut put = |values: &[f64]| values.iter().for_each(|v| hash.update(v.to_bits().to_le_bytes()));
        let material = |m: &Material| [m.youngs_modulus, m.poisson_ratio, m.density];
        let hold = |h: Hold| f64::from(u8::from(h == Hold::Bolts));
        let (c, h) = (&self.carrier, &self.housing);
        let s = &c.solid;
        put(&[FORMAT as f64, s.plate_radius, s.centre_bore_radius, s.crank_seat_radius, s.plate_thickness]);
        put(&[s.gap, hold(s.hold), c.size, c.layers[0] as f64, c.layers[1] as f64]);
        put(&[s.pillars.len() as f64, c.cranks.len() as f64]);
        for p in &s.pillars {
            put(&[p.inner_radius, p.outer_radius, p.centre_angle, p.half_angle, p.corner_radius]);
        }
        c.cranks.iter().for_each(|place| put(&[place.x, place.y]));
        put(&material(&c.material));
        let s = &h.solid;
        put(&material(&s.material));
        put(&[s.body_radius, s.seat_radius, s.flange_radius, s.flange_thickness, s.bolt_circle_radius]);
        put(&[s.bolt_count as f64, s.first_bolt_angle, s.bolt_face_radius, hold(s.hold)]);
        put(&[h.pin_count as f64, h.pin_circle_radius, h.groove_radius, h.disc_count as f64]);
        put(&[h.seat_length, h.pin_length, h.sizes[0], h.sizes[1]]);
        put(&h.layers.map(|layers| layers as f64));
        hash.finalize().into()
    }

    /// 64 hexadecimal digits: a file name.
    pub fn key_hex(&self) -> String {
        self.key().iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// Layout: magic, key, per body its count and its matrix (little-endian), SHA-256 of all before.
    pub fn to_bytes(&self, bodies: &ElasticBodies) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend_from_slice(&self.key());
        for body in [&bodies.carrier, &bodies.housing] {
            bytes.extend_from_slice(&(body.count as u64).to_le_bytes());
            body.values.iter().for_each(|v| bytes.extend_from_slice(&v.to_le_bytes()));
        }
        let checksum: [u8; 32] = Sha256::digest(&bytes).into();
        bytes.extend_from_slice(&checksum);
        bytes
    }

    /// Reads [`BodyShapes::to_bytes`] back.
    ///
    /// # Errors
    /// [`CacheError`] if the bytes are incomplete, damaged, or of other solids.
    pub fn from_bytes(&self, bytes: &[u8]) -> Result<ElasticBodies, CacheError> {
        let rest = bytes.strip_prefix(MAGIC).ok_or(CacheError::Foreign)?;
        let (key, _) = rest.split_at_checked(32).ok_or(CacheError::Damaged)?;
        if key != self.key() {
            return Err(CacheError::OtherKey);
        }
        let end = bytes.len().checked_sub(32).ok_or(CacheError::Damaged)?;
        let (data, checksum) = bytes.split_at(end);
        let digest: [u8; 32] = Sha256::digest(data).into();
        if digest != *checksum || data.len() < 40 {
            return Err(CacheError::Damaged);
        }
        let mut words = data[40..].chunks_exact(8).map(|w| {
            let mut word = [0; 8];
            word.copy_from_slice(w);
            word
        });
        let mut matrix = || {
            let count = u64::from_le_bytes(words.next()?);
            let count = usize::try_from(count).ok().filter(|count| *count < 100_000)?;
            let values: Vec<f64> = words.by_ref().take(count * count).map(f64::from_le_bytes).collect();
            (values.len() == count * count).then_some(Compliance { count, values })
        };
        match (matrix(), matrix()) {
            (Some(carrier), Some(housing)) => Ok(ElasticBodies { carrier, housing }),
            _ => Err(CacheError::Damaged),
        }
    }
}

impl ElasticBodies {
    /// The same bodies of materials `factor` times stiffer.
    pub fn stiffened(&self, factor: f64) -> ElasticBodies {
        ElasticBodies { carrier: self.carrier.stiffened(factor), housing: self.housing.stiffened(factor) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some(count: usize) -> Compliance {
        Compliance { count, values: (0..count * count).map(|k| (k as f64).sin()).collect() }
    }

    /// Stored bytes are read back unchanged; those of other solids, truncated and modified ones are refused.
    #[test]
    fn bytes_are_accepted_for_their_own_solids_only() {
        let shapes = BodyShapes::of(&crate::templates::tao2024());
        let bodies = ElasticBodies { carrier: some(5), housing: some(7) };
        let bytes = shapes.to_bytes(&bodies);
        assert_eq!(shapes.from_bytes(&bytes), Ok(bodies));
        let mut other = shapes.clone();
        other.housing.solid.bolt_count += 1;
        assert_ne!(other.key(), shapes.key());
        assert_eq!(other.from_bytes(&bytes), Err(CacheError::OtherKey));
        assert_eq!(shapes.from_bytes(b"something else"), Err(CacheError::Foreign));
        for end in [8, 20, 60, bytes.len() - 1] {
            assert_eq!(shapes.from_bytes(&bytes[..end]), Err(CacheError::Damaged), "{end}");
        }
        let mut changed = bytes.clone();
        changed[100] ^= 1;
        assert_eq!(shapes.from_bytes(&changed), Err(CacheError::Damaged));
    }
}
