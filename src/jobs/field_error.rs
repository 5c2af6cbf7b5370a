//! Fields of plans and keys that hold what they may not hold.

/// A field of a plan or a key that holds a value that it may not have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field} is {value}: expected {expected}")]
pub struct FieldError {
    /// Name of the field, preceded by the fields that contain it.
    pub field: String,
    /// Value of the field, without control characters.
    pub value: String,
    /// Values that it may have.
    pub expected: String,
}

impl FieldError {
    pub(crate) fn new(
        field: impl Into<String>,
        value: impl Into<String>,
        expected: impl Into<String>,
    ) -> FieldError {
        FieldError {
            field: field.into(),
            value: value.into(),
            expected: expected.into(),
        }
    }
}
