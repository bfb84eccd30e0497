//! Sums in number fields: `2*3`, `(1 + 2) / 4`, `-1e-3`.

/// Brackets and signs within each other; more are nobody's sum.
const MOST_DEPTH: usize = 32;

/// What the text comes to, by the usual rules: `+ - * / ( )`, numbers with a point and an exponent, blanks and typographic signs as people
/// paste them. `inf` is infinite. `None` where it is no sum, or where what comes out is no number.
#[must_use]
pub fn worked_out(text: &str) -> Option<f64> {
    let plain = |sign: char| match sign {
        '−' => '-',
        '×' | '·' => '*',
        '÷' => '/',
        sign => sign,
    };
    let text = text.chars().filter(|sign| !sign.is_whitespace());
    let text: String = text.map(plain).collect();
    let mut rest = Rest {
        text: &text,
        depth: 0,
    };
    let value = rest.sum()?;
    (rest.text.is_empty() && !value.is_nan()).then_some(value)
}

/// What is still to be read.
struct Rest<'a> {
    text: &'a str,
    depth: usize,
}

impl Rest<'_> {
    /// Takes the next sign where it is one of `signs`.
    fn take(&mut self, signs: [char; 2]) -> Option<char> {
        let sign = self
            .text
            .chars()
            .next()
            .filter(|sign| signs.contains(sign))?;
        self.text = &self.text[sign.len_utf8()..];
        Some(sign)
    }

    fn sum(&mut self) -> Option<f64> {
        let mut value = self.product()?;
        while let Some(sign) = self.take(['+', '-']) {
            let next = self.product()?;
            value += if sign == '+' { next } else { -next };
        }
        Some(value)
    }

    fn product(&mut self) -> Option<f64> {
        let mut value = self.factor()?;
        while let Some(sign) = self.take(['*', '/']) {
            let next = self.factor()?;
            value = if sign == '*' {
                value * next
            } else {
                value / next
            };
        }
        Some(value)
    }

    fn factor(&mut self) -> Option<f64> {
        self.depth += 1;
        if self.depth > MOST_DEPTH {
            return None;
        }
        let value = if let Some(sign) = self.take(['+', '-']) {
            let value = self.factor()?;
            if sign == '-' { -value } else { value }
        } else if self.take(['(', '(']).is_some() {
            let value = self.sum()?;
            self.take([')', ')'])?;
            value
        } else {
            self.number()?
        };
        self.depth -= 1;
        Some(value)
    }

    fn number(&mut self) -> Option<f64> {
        let bytes = self.text.as_bytes();
        if bytes
            .get(..3)
            .is_some_and(|word| word.eq_ignore_ascii_case(b"inf"))
        {
            self.text = &self.text[3..];
            return Some(f64::INFINITY);
        }
        let is_exponent_sign = |at: usize| {
            matches!(bytes[at], b'+' | b'-') && at > 0 && matches!(bytes[at - 1], b'e' | b'E')
        };
        let belongs = |at: usize| {
            matches!(bytes[at], b'0'..=b'9' | b'.' | b'e' | b'E') || is_exponent_sign(at)
        };
        let length = (0..bytes.len()).take_while(|&at| belongs(at)).count();
        let (number, rest) = self.text.split_at(length);
        self.text = rest;
        number.parse().ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_worked_out_by_the_usual_rules() {
        for (text, value) in [
            ("12", 12.0),
            (" 1 234.5 ", 1234.5),
            ("2*3", 6.0),
            ("2+3*4", 14.0),
            ("(2+3)*4", 20.0),
            ("10-4-3", 3.0),
            ("12/4/3", 1.0),
            ("-1e-3", -1e-3),
            ("2--3", 5.0),
            ("2*-3", -6.0),
            ("1e2+1E+1", 110.0),
            (".5", 0.5),
            ("−3 × 2", -6.0),
            ("1.5e300", 1.5e300),
            ("inf", f64::INFINITY),
        ] {
            assert_eq!(worked_out(text), Some(value), "{text}");
        }
    }

    #[test]
    fn what_is_no_sum_is_refused() {
        let deep = "(".repeat(100_000);
        let signs = "-".repeat(100_000);
        for text in [
            "",
            "nan",
            "NaN",
            "2*",
            "*2",
            "2**3",
            "(2",
            "2)",
            "1,5",
            "one",
            "0/0",
            "inf-inf",
            "1e",
            "2 m",
            "é",
            "+",
            deep.as_str(),
            &signs,
        ] {
            assert_eq!(worked_out(text), None, "{text:.20}");
        }
    }
}
