//! Laws that a design chooses by name: one declaration gives the law with its parameters in SI units, its word
//! and meaning for reader, reference and options, and the keys of its parameters.

/// An unknown name of a law.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("\"{found}\" is not a {kind}; choose one of {}", .known.iter().map(|(word, _)| format!("\"{word}\"")).collect::<Vec<_>>().join(", "))]
pub struct UnknownLaw {
    /// Kind of law.
    pub kind: &'static str,
    /// The unknown word.
    pub found: String,
    /// Words and meanings of all laws of the kind.
    pub known: &'static [(&'static str, &'static str)],
}

/// The names of a kind of law, see `named_laws!`.
pub trait LawName: Copy + PartialEq + 'static {
    /// The law with its parameters.
    type Law;
    /// Kind of law, for messages.
    const KIND: &'static str;
    /// Every name, in the order of the declaration.
    const NAMES: &'static [Self];
    /// The word and the meaning of every name, in the same order.
    const WORDS: &'static [(&'static str, &'static str)];

    /// The word of the law in designs and options.
    fn word(self) -> &'static str;

    /// Keys of its parameters, with units in their names.
    fn parameters(self) -> &'static [&'static str];

    /// The law with its parameters in the order and units of [`LawName::parameters`]; `None` unless all are
    /// given.
    fn law(self, parameters: &[f64]) -> Option<Self::Law>;

    /// The law called `word`.
    ///
    /// # Errors
    /// [`UnknownLaw`] with the known names.
    fn from_word(word: &str) -> Result<Self, UnknownLaw> {
        Self::NAMES.iter().copied().find(|name| name.word() == word).ok_or_else(|| UnknownLaw {
            kind: Self::KIND,
            found: word.to_owned(),
            known: Self::WORDS,
        })
    }
}

/// Declares the laws of a kind: `"word", "meaning": Variant { field: "key_with_unit" => |p| p[0] * UNIT }`.
/// The functions get all parameters of the law in the order of its fields, in the units of their keys.
macro_rules! named_laws {
    (
        $(#[$law_doc:meta])* pub enum $Law:ident;
        $(#[$name_doc:meta])* pub enum $Name:ident, $kind:literal;
        $($(#[$doc:meta])* $word:literal, $meaning:literal:
            $Variant:ident $({ $($(#[$field_doc:meta])* $field:ident: $key:literal => $si:expr,)* })?,)*
    ) => {
        $(#[$law_doc])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub enum $Law {
            $($(#[$doc])* $Variant $({ $($(#[$field_doc])* $field: f64,)* })?,)*
        }

        $(#[$name_doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
        pub enum $Name {
            $(#[doc = $meaning] #[serde(rename = $word)] $Variant,)*
        }

        impl $Law {
            /// Name of the law, without its parameters.
            pub fn name(&self) -> $Name {
                match self { $($Law::$Variant { .. } => $Name::$Variant,)* }
            }
        }

        impl $crate::named::LawName for $Name {
            type Law = $Law;
            const KIND: &'static str = $kind;
            const NAMES: &'static [$Name] = &[$($Name::$Variant,)*];
            const WORDS: &'static [(&'static str, &'static str)] = &[$(($word, $meaning),)*];

            fn word(self) -> &'static str {
                match self { $($Name::$Variant => $word,)* }
            }

            fn parameters(self) -> &'static [&'static str] {
                match self { $($Name::$Variant => &[$($($key,)*)?],)* }
            }

            fn law(self, parameters: &[f64]) -> Option<$Law> {
                if parameters.len() != self.parameters().len() {
                    return None;
                }
                Some(match self {
                    $($Name::$Variant => $Law::$Variant {
                        $($($field: { let si: fn(&[f64]) -> f64 = $si; si(parameters) },)*)?
                    },)*
                })
            }
        }

        impl std::str::FromStr for $Name {
            type Err = $crate::named::UnknownLaw;

            fn from_str(word: &str) -> Result<$Name, $crate::named::UnknownLaw> {
                $crate::named::LawName::from_word(word)
            }
        }

        impl std::fmt::Display for $Name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str($crate::named::LawName::word(*self))
            }
        }
    };
}

pub(crate) use named_laws;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::ContactLawName;
    use crate::tribology::WearLawName;

    fn words_and_parameters_agree<N: LawName + std::fmt::Debug>() {
        for (name, (word, meaning)) in N::NAMES.iter().zip(N::WORDS) {
            assert_eq!(name.word(), *word);
            assert_eq!(N::from_word(word).ok(), Some(*name));
            assert!(!meaning.is_empty());
            let numbers = vec![1.0; name.parameters().len()];
            assert!(name.law(&numbers).is_some());
            assert!(name.law(&[numbers, vec![1.0]].concat()).is_none());
        }
    }

    #[test]
    fn every_law_is_found_by_its_word_and_needs_its_parameters() {
        words_and_parameters_agree::<ContactLawName>();
        words_and_parameters_agree::<WearLawName>();
    }

    #[test]
    fn an_unknown_word_is_answered_with_the_choices() {
        let error = "hertz".parse::<ContactLawName>().unwrap_err();
        assert_eq!(
            error.to_string(),
            "\"hertz\" is not a contact law; choose one of \"line-hertz\", \"linear\", \"palmgren\", \"tao2024\", \"impact\""
        );
    }

    /// N/mm^e becomes N/m^e with the exponent of the same law.
    #[test]
    fn parameters_become_si() {
        let law = ContactLawName::Impact.law(&[1e6, 1.1]);
        let expected =
            crate::contact::ContactLaw::Impact { stiffness: 1e6 * 1e3_f64.powf(1.1), exponent: 1.1 };
        assert_eq!(law, Some(expected));
    }
}
