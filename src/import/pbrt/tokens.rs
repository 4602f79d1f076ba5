//! The tokens of a file: words, texts in quotes, and brackets.

use std::borrow::Cow;

#[derive(Debug, PartialEq)]
pub(super) enum Token<'a> {
    /// A directive, a number, `true` or `false`.
    Word(&'a str),
    /// What was in quotes.
    Text(Cow<'a, str>),
    Open,
    Close,
}

/// The tokens that are left of a file.
#[derive(Clone, Copy)]
pub(super) struct Tokens<'a> {
    rest: &'a str,
    line: u32,
}

impl<'a> Tokens<'a> {
    pub fn new(text: &'a str) -> Self {
        Self { rest: text.trim_start_matches('\u{feff}'), line: 1 }
    }

    /// The line of the token that was read last.
    pub fn line(&self) -> u32 {
        self.line
    }

    /// The next token, left where it is; `None` at the end.
    pub fn peek(&self) -> Result<Option<Token<'a>>, String> {
        let mut ahead = *self;
        ahead.next()
    }

    /// Takes the next token; `None` at the end.
    pub fn next(&mut self) -> Result<Option<Token<'a>>, String> {
        self.skip_blanks();
        let Some(first) = self.rest.chars().next() else { return Ok(None) };
        Ok(Some(match first {
            '[' => {
                self.advance(1);
                Token::Open
            }
            ']' => {
                self.advance(1);
                Token::Close
            }
            '"' => {
                self.advance(1);
                Token::Text(self.text()?)
            }
            _ => {
                let ends = |c: char| c.is_whitespace() || matches!(c, '"' | '[' | ']' | '#');
                let end = self.rest.find(ends).unwrap_or(self.rest.len());
                Token::Word(self.advance(end))
            }
        }))
    }

    /// Goes on to the next directive: only their names are words with a capital letter.
    pub fn skip_to_directive(&mut self) {
        loop {
            match self.peek() {
                Ok(Some(Token::Word(word)))
                    if word.starts_with(|c: char| c.is_ascii_uppercase()) =>
                {
                    return;
                }
                Ok(None) => return,
                // What is no token is passed over, too.
                _ => drop(self.next()),
            }
        }
    }

    /// Passes over some bytes, and returns them.
    fn advance(&mut self, bytes: usize) -> &'a str {
        let (passed, rest) = self.rest.split_at(bytes);
        self.line += passed.bytes().filter(|byte| *byte == b'\n').count() as u32;
        self.rest = rest;
        passed
    }

    fn skip_blanks(&mut self) {
        loop {
            let blanks = self.rest.len() - self.rest.trim_start().len();
            self.advance(blanks);
            if !self.rest.starts_with('#') {
                return;
            }
            self.advance(self.rest.find('\n').unwrap_or(self.rest.len()));
        }
    }

    /// The text up to its closing quote, which must be in the same line.
    fn text(&mut self) -> Result<Cow<'a, str>, String> {
        let mut decoded = String::new();
        loop {
            let end = self.rest.find(['"', '\\', '\n']).unwrap_or(self.rest.len());
            let part = self.advance(end);
            match self.rest.bytes().next() {
                Some(b'"') => {
                    self.advance(1);
                    if decoded.is_empty() {
                        return Ok(part.into());
                    }
                    decoded.push_str(part);
                    return Ok(decoded.into());
                }
                Some(b'\\') => {
                    decoded.push_str(part);
                    self.advance(1);
                    let Some(c) = self.rest.chars().next() else { continue };
                    self.advance(c.len_utf8());
                    decoded.push(match c {
                        'n' => '\n',
                        't' => '\t',
                        'r' => '\r',
                        'b' => '\u{8}',
                        'f' => '\u{c}',
                        other => other,
                    });
                }
                _ => return Err("a text has no closing quote".to_owned()),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_are_found_with_their_lines() {
        let mut tokens =
            Tokens::new("\u{feff}# a comment\nShape\"a\\\"b\\n\" [-1.5e3 true]# end\r\n\"é\" \"");
        let mut next = || (tokens.next(), tokens.line());
        assert_eq!(next(), (Ok(Some(Token::Word("Shape"))), 2));
        assert_eq!(next(), (Ok(Some(Token::Text("a\"b\n".into()))), 2));
        assert_eq!(next(), (Ok(Some(Token::Open)), 2));
        assert_eq!(next(), (Ok(Some(Token::Word("-1.5e3"))), 2));
        assert_eq!(next(), (Ok(Some(Token::Word("true"))), 2));
        assert_eq!(next(), (Ok(Some(Token::Close)), 2));
        assert_eq!(next(), (Ok(Some(Token::Text("é".into()))), 3));
        assert!(next().0.is_err());
        assert_eq!(next(), (Ok(None), 3));
        let mut tokens = Tokens::new("1 \"open\n] Shape");
        tokens.skip_to_directive();
        assert_eq!(tokens.next(), Ok(Some(Token::Word("Shape"))));
    }
}
