//! Choosing the widest vector instructions of the machine while the program runs.
//!
//! A [`Query`] is ordinary code with loops over lanes. It is compiled twice: for the instructions every machine has, and for
//! AVX2, where a loop over eight lanes is one instruction per operation. Both round every operation alike: fused
//! multiply-adds, which would not, are neither asked for nor enabled. So both answer with the same bits.

/// Code that gains from wide instructions.
pub(super) trait Query {
    type Answer;

    /// Always inlined, as is everything with loops over lanes that it calls, so that it is compiled with the instructions of
    /// its caller.
    fn answer(&self) -> Self::Answer;
}

/// The answer, by the widest instructions there are.
#[inline]
pub(super) fn answer<Q: Query>(query: &Q) -> Q::Answer {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
    {
        #[expect(unsafe_code, reason = "the instructions are there, as just asked")]
        // SAFETY: the only condition is that the machine has the features enabled for the function.
        return unsafe { with_avx2(query) };
    }
    query.answer()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2")]
fn with_avx2<Q: Query>(query: &Q) -> Q::Answer {
    query.answer()
}
