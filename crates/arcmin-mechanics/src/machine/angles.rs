//! Separate types for angles of crankshaft and output, which differ by a factor of 81.

use crate::units::{ARCMIN, DEG};

macro_rules! role_angle {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default)]
        pub struct $name(f64);

        impl $name {
            /// From an angle in rad.
            pub const fn from_radians(radians: f64) -> $name {
                $name(radians)
            }
            /// From an angle in degrees.
            pub fn from_degrees(degrees: f64) -> $name {
                $name(degrees * DEG)
            }
            /// In rad.
            pub const fn radians(self) -> f64 {
                self.0
            }
            /// In degrees.
            pub fn degrees(self) -> f64 {
                self.0 / DEG
            }
            /// In arc minutes.
            pub fn arcmin(self) -> f64 {
                self.0 / ARCMIN
            }
        }
    };
}

role_angle!(
    /// Absolute angle θ_k of the crankshafts.
    CrankAngle
);
role_angle!(
    /// Absolute angle θ_o of the output, or an error of it; negative values lag behind.
    OutputAngle
);
