//! Seeded damage to files: bytes, words, lines, numbers and nesting of texts, fields of binary headers.

/// Numbers of a linear congruential generator (Knuth, MMIX), enough to damage files with.
pub struct Dice(pub u64);

impl Dice {
    pub fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 33) as usize) % n.max(1)
    }

    pub fn pick<'a, T: ?Sized>(&mut self, items: &[&'a T]) -> &'a T {
        items[self.below(items.len())]
    }
}

/// Words that have broken loaders.
const WORDS: [&str; 37] = [
    "nan",
    "inf",
    "1e400",
    "1e99",
    "1e-320",
    "-1",
    "0",
    "-0.0",
    "2147483648",
    "9999999999999999999",
    "/",
    "//",
    "1//1",
    "f ",
    "l 1 2 3\n",
    "Kd 0.5 0.5\n",
    "\n",
    "\t",
    "\r\n",
    "[[",
    "]]",
    "[",
    "{",
    "}",
    "\"",
    "'''",
    "=",
    "a.b.c = 1\n",
    "usemtl \n",
    "mtllib a.mtl a.mtl\n",
    "newmtl m\n",
    "map_Kd -s 1 1 1 my x.png\n",
    "# ",
    "\u{1b}[31m",
    "\u{202e}",
    "\u{feff}",
    "灰",
];

/// Numbers in place of others.
const NUMBERS: [&str; 20] = [
    "0",
    "-0.0",
    "-1",
    "1e100",
    "-1e100",
    "1e-100",
    "1e101",
    "1e36",
    "1e-36",
    "1e-45",
    "3.4e38",
    "nan",
    "inf",
    "16384",
    "16385",
    "65535",
    "4294967295",
    "4294967296",
    "18446744073709551616",
    "0x7fffffff",
];

/// A text damaged once to four times.
pub fn text(original: &str, dice: &mut Dice) -> Vec<u8> {
    let mut bytes = original.as_bytes().to_vec();
    for _ in 0..=dice.below(4) {
        bytes = match dice.below(8) {
            0..3 => damaged_bytes(bytes, dice),
            3 => damaged_words(&bytes, dice),
            4 => damaged_lines(&bytes, dice),
            5 => damaged_number(&bytes, dice),
            6 => nested(bytes, dice),
            _ => inserted(bytes, dice.pick(&WORDS).as_bytes(), dice),
        };
    }
    bytes
}

fn damaged_bytes(mut bytes: Vec<u8>, dice: &mut Dice) -> Vec<u8> {
    let at = dice.below(bytes.len() + 1);
    match dice.below(16) {
        0..8 if at < bytes.len() => bytes[at] = dice.below(256) as u8,
        8..15 if at < bytes.len() => drop(bytes.remove(at)),
        _ => bytes.truncate(at),
    }
    bytes
}

fn inserted(mut bytes: Vec<u8>, word: &[u8], dice: &mut Dice) -> Vec<u8> {
    let at = dice.below(bytes.len() + 1);
    bytes.splice(at..at, word.iter().copied());
    bytes
}

/// Two words change places.
fn damaged_words(bytes: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut words: Vec<&[u8]> = bytes.split_inclusive(|&byte| byte == b' ' || byte == b'\n').collect();
    let (a, b) = (dice.below(words.len()), dice.below(words.len()));
    if a < words.len() && b < words.len() {
        words.swap(a, b);
    }
    words.concat()
}

/// A line goes, comes again once to a thousand times, or moves.
fn damaged_lines(bytes: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut lines: Vec<&[u8]> = bytes.split_inclusive(|&byte| byte == b'\n').collect();
    let (a, b) = (dice.below(lines.len()), dice.below(lines.len()));
    if lines.is_empty() {
        return Vec::new();
    }
    match dice.below(4) {
        0 => drop(lines.remove(a)),
        1 => lines.swap(a, b),
        2 => lines.insert(b, lines[a]),
        _ => drop(lines.splice(b..b, vec![lines[a]; 1 + dice.below(1000)])),
    }
    lines.concat()
}

/// The digits at some place, and what belongs to them, become another number.
fn damaged_number(bytes: &[u8], dice: &mut Dice) -> Vec<u8> {
    let is_number = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'-' | b'e');
    let start = dice.below(bytes.len());
    let Some(from) = bytes[start.min(bytes.len())..].iter().position(u8::is_ascii_digit).map(|at| start + at) else {
        return bytes.to_vec();
    };
    let to = from + bytes[from..].iter().take_while(|byte| is_number(byte)).count();
    [&bytes[..from], dice.pick(&NUMBERS).as_bytes(), &bytes[to..]].concat()
}

/// Brackets, braces, dots or words in great number.
fn nested(bytes: Vec<u8>, dice: &mut Dice) -> Vec<u8> {
    let count = 1 << dice.below(14);
    let what = dice.pick(&["[", "{a=", ".a", "]", "\"", "1 ", "/", "a", "[[a]]\n", "1/1/1 ", "-"]).repeat(count);
    inserted(bytes, what.as_bytes(), dice)
}

/// Words of 32 bits that sizes and places are forged with.
const FIELDS: [u32; 12] =
    [0, 1, 2, 7, 16384, 65536, 1 << 24, 1 << 29, 0x7fff_ffff, 0x8000_0000, 0xffff_fffe, 0xffff_ffff];

/// Names behind which, at that many bytes, the fields of an OpenEXR header stand that sizes come from.
const NAMED: [(&[u8], usize); 8] = [
    (b"dataWindow\0box2i\0", 20),
    (b"displayWindow\0box2i\0", 20),
    (b"tiles\0tiledesc\0", 13),
    (b"compression\0compression\0", 5),
    (b"channels\0chlist\0", 40),
    (b"lineOrder\0lineOrder\0", 5),
    (b"chunkCount\0int\0", 8),
    (b"type\0string\0", 20),
];

/// A binary file damaged once to four times: bytes, words of 32 bits anywhere, and fields of an OpenEXR header.
pub fn binary(original: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut bytes = original.to_vec();
    for _ in 0..=dice.below(4) {
        let length = bytes.len();
        match dice.below(8) {
            0..2 => bytes = damaged_bytes(bytes, dice),
            2 => put(&mut bytes, dice.below(length), FIELDS[dice.below(12)].to_le_bytes().as_slice()),
            3 if length > 8 => {
                // Two stretches change places, as chunks and their table may.
                let (a, b, count) = (dice.below(length), dice.below(length), 1 + dice.below(16));
                let stretch = bytes[a..(a + count).min(length)].to_vec();
                put(&mut bytes, b, &stretch);
            }
            4 => bytes = [bytes.as_slice(), &vec![0; dice.below(1 << 12)]].concat(),
            _ => {
                let (name, reach) = NAMED[dice.below(8)];
                if let Some(at) = bytes.windows(name.len()).position(|window| window == name) {
                    let field = match dice.below(3) {
                        0 => vec![dice.below(256) as u8],
                        _ => FIELDS[dice.below(12)].to_le_bytes().to_vec(),
                    };
                    // Mostly at words of the value, whose size of four bytes comes first.
                    let behind = if dice.below(4) == 0 { dice.below(reach) } else { 4 * dice.below(reach / 4 + 1) };
                    put(&mut bytes, at + name.len() + behind, &field);
                }
            }
        }
    }
    bytes
}

fn put(bytes: &mut [u8], at: usize, field: &[u8]) {
    bytes.iter_mut().skip(at).zip(field).for_each(|(byte, new)| *byte = *new);
}
