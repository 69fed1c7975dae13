//! Choices of a few values, each stated once with its name and what it is.
//!
//! Comes in: an enum with a name and a sentence per value. Goes out: [`Named`], from which the command line makes the
//! values of an option with their help, JSON its strings, and messages their words.

/// A choice of a few values by name.
pub trait Named: Copy + PartialEq + Send + Sync + 'static {
    /// Every value, in the order in which help lists them.
    const ALL: &'static [Self];

    /// Its name, as it is typed and printed.
    fn name(self) -> &'static str;

    /// What it is, in the words of its documentation.
    fn help(self) -> &'static str;

    /// The value of this name.
    fn of_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|value| value.name() == name)
    }
}

/// Makes an enum whose values have names, and a default where one is given: the names serve [`Named`] and serde.
macro_rules! named {
    (
        $(#[$meta:meta])*
        pub enum $Choice:ident $(= $default:ident)? {
            $($(#[doc = $help:literal])+ $Value:ident = $name:literal,)+
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $Choice {
            $($(#[doc = $help])+ $Value,)+
        }

        impl $crate::named::Named for $Choice {
            const ALL: &'static [$Choice] = &[$($Choice::$Value,)+];

            fn name(self) -> &'static str {
                match self {
                    $($Choice::$Value => $name,)+
                }
            }

            fn help(self) -> &'static str {
                match self {
                    $($Choice::$Value => concat!($($help,)+).trim_ascii(),)+
                }
            }
        }

        impl serde::Serialize for $Choice {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
                serializer.serialize_str($crate::named::Named::name(*self))
            }
        }

        $(
            impl Default for $Choice {
                fn default() -> $Choice {
                    $Choice::$default
                }
            }
        )?
    };
}

pub(crate) use named;

#[cfg(test)]
mod tests {
    use super::Named;

    named! {
        /// A choice.
        pub enum Fruit = Pear {
            /// Round, and
            /// red.
            Apple = "apple",
            /// Not round.
            Pear = "long-pear",
        }
    }

    #[test]
    fn a_value_has_its_name_and_its_help() {
        assert_eq!(Fruit::ALL, [Fruit::Apple, Fruit::Pear]);
        assert_eq!(Fruit::ALL.iter().map(|fruit| fruit.help()).collect::<Vec<_>>(), ["Round, and red.", "Not round."]);
        assert_eq!((Fruit::of_name("long-pear"), Fruit::of_name("pear")), (Some(Fruit::default()), None));
        assert_eq!(serde_json::to_value(Fruit::Pear).unwrap(), "long-pear");
    }
}
