//! Reduced discs as bytes, stored between runs by the caller.
//!
//! Layout: magic, key, payload (little-endian counts and doubles), SHA-256 of all before. The key is the SHA-256 of
//! everything the reduction depends on and of the format's version, so the cache of another disc or of an older
//! program is never used.

use sha2::{Digest, Sha256};

use super::flank::LOBE_REFINEMENT;
use super::reduced::{FlankCompliance, Interface};
use super::{BoreInterface, DiscElement, DiscShape, FlankStations, FlexibleSettings, ReducedDisc};

const MAGIC: &[u8; 8] = b"arcminFE";
/// Version; increase it whenever the reduction or this layout changes its results.
const FORMAT: u64 = 3;

/// Reason why a cache is not used. The disc is then reduced again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum CacheError {
    /// The bytes have another header.
    #[error("not a cache of a reduced disc")]
    Foreign,
    /// The key in the cache is another one.
    #[error("the cache belongs to another disc, mesh or version")]
    OtherKey,
    /// Lengths or numbers in the cache contradict each other.
    #[error("the cache is damaged")]
    Damaged,
}

/// Identifies a reduction: equal keys, equal results.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CacheKey([u8; 32]);

impl CacheKey {
    /// The key of a shape and its settings, by SHA-256 over both and the version of the format.
    pub fn of(shape: &DiscShape, settings: &FlexibleSettings) -> CacheKey {
        let mut hash = Sha256::new();
        let mut put = |values: &[f64]| values.iter().for_each(|v| hash.update(v.to_bits().to_le_bytes()));
        put(&[
            FORMAT as f64,
            shape.profile.pin_count as f64,
            shape.profile.pin_circle_radius,
            shape.profile.eccentricity,
            shape.profile.pin_radius,
        ]);
        put(&[
            shape.width,
            shape.material.youngs_modulus,
            shape.material.poisson_ratio,
            shape.material.density,
        ]);
        for holes in [&shape.bores, &shape.holes] {
            put(&[holes.len() as f64]);
            holes.iter().for_each(|hole| put(&[hole.centre.x, hole.centre.y, hole.radius]));
        }
        for w in &shape.windows {
            put(&[w.inner_radius, w.outer_radius, w.centre_angle, w.half_angle, w.corner_radius]);
        }
        let s = &settings.sizes;
        let layers = match settings.element {
            DiscElement::PlaneStress => 0.0,
            DiscElement::Solid { layers } => layers as f64,
        };
        let interface = match settings.interface {
            BoreInterface::PerBore => 0.0,
            BoreInterface::Common => 1.0,
            BoreInterface::Rims => 2.0,
            BoreInterface::Means => 3.0,
        };
        put(&[layers, interface, s.flank, s.flank_rows as f64, s.bore, s.hole, s.interior]);
        put(&[settings.stations_per_lobe as f64, settings.reading_depth, settings.mode_frequency]);
        CacheKey(hash.finalize().into())
    }

    /// 64 hexadecimal digits: a file name.
    pub fn hex(&self) -> String {
        self.0.iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

impl ReducedDisc {
    /// The cache as bytes, which only the same key reads again.
    pub fn to_bytes(&self, key: &CacheKey) -> Vec<u8> {
        let mut bytes = Vec::new();
        bytes.extend_from_slice(MAGIC);
        bytes.extend_from_slice(&key.0);
        for count in [
            self.lobe_count,
            self.stations.per_lobe(),
            self.normal_modes,
            self.eigenvalues.len(),
            self.interface.count,
            self.interface.per_bore,
        ] {
            bytes.extend_from_slice(&(count as u64).to_le_bytes());
        }
        bytes.extend_from_slice(&self.reading_depth.to_le_bytes());
        let [x, y, turn] = &self.momentum;
        let (c, i) = (&self.compliance, &self.interface);
        for field in [
            &self.eigenvalues,
            &self.flank_modes,
            &c.cross,
            &c.own,
            &c.own_detail,
            x,
            y,
            turn,
            &i.stiffness,
            &i.mass,
            &i.coupling,
            &i.flank,
        ] {
            field.iter().for_each(|v| bytes.extend_from_slice(&v.to_le_bytes()));
        }
        let checksum: [u8; 32] = Sha256::digest(&bytes).into();
        bytes.extend_from_slice(&checksum);
        bytes
    }

    /// Reads the bytes of [`ReducedDisc::to_bytes`] for the same shape and settings.
    ///
    /// # Errors
    /// [`CacheError`] if the bytes are not such a cache; the disc must be reduced again.
    pub fn from_bytes(
        bytes: &[u8],
        shape: &DiscShape,
        settings: &FlexibleSettings,
    ) -> Result<ReducedDisc, CacheError> {
        if bytes.len() < 72 || &bytes[..8] != MAGIC {
            return Err(CacheError::Foreign);
        }
        let (body, checksum) = bytes.split_at(bytes.len() - 32);
        let expected: [u8; 32] = Sha256::digest(body).into();
        if checksum != expected {
            return Err(CacheError::Damaged);
        }
        if body[8..40] != CacheKey::of(shape, settings).0 {
            return Err(CacheError::OtherKey);
        }
        let mut words = body[40..].chunks_exact(8).map(|word| word.try_into().unwrap_or([0; 8]));
        let mut count =
            || words.next().map(|word| u64::from_le_bytes(word) as usize).ok_or(CacheError::Damaged);
        let (lobe_count, per_lobe, normal_modes) = (count()?, count()?, count()?);
        let (modes, interface, per_bore) = (count()?, count()?, count()?);
        let stations = FlankStations::new(&shape.profile, settings.stations_per_lobe);
        if lobe_count != shape.profile.lobe_count() || per_lobe != stations.per_lobe() {
            return Err(CacheError::Damaged);
        }
        let places = stations.count();
        let mut numbers = words.map(f64::from_le_bytes);
        let reading_depth = numbers.next().ok_or(CacheError::Damaged)?;
        let mut field = |length: usize| {
            let values: Vec<f64> = numbers.by_ref().take(length).collect();
            if values.len() == length { Ok(values) } else { Err(CacheError::Damaged) }
        };
        Ok(ReducedDisc {
            lobe_count,
            reading_depth,
            normal_modes,
            eigenvalues: field(modes)?,
            flank_modes: field(modes * places)?,
            compliance: FlankCompliance {
                stations: places,
                cross: field(places * places)?,
                own: field(places)?,
                own_detail: field(per_lobe * LOBE_REFINEMENT)?,
            },
            momentum: [field(modes)?, field(modes)?, field(modes)?],
            interface: Interface {
                count: interface,
                per_bore,
                stiffness: field(interface * interface)?,
                mass: field(interface * interface)?,
                coupling: field(interface * modes)?,
                flank: field(interface * places)?,
            },
            stations,
        })
    }
}
