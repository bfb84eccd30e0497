//! What a PLY file says about itself before its data.

use crate::io::mesh_reading::{Cursor, Malformed, whole};

/// The types of numbers, with both of their names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn of(word: &[u8]) -> Option<Self> {
        Some(match word {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// What stands for white in a channel of this type; numbers with a point go to 1.
    pub fn white(self) -> f64 {
        match self {
            Self::I8 => f64::from(i8::MAX),
            Self::U8 => f64::from(u8::MAX),
            Self::I16 => f64::from(i16::MAX),
            Self::U16 => f64::from(u16::MAX),
            Self::I32 => f64::from(i32::MAX),
            Self::U32 => f64::from(u32::MAX),
            Self::F32 | Self::F64 => 1.0,
        }
    }

    /// Bytes of one in binary data.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// What a property holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    One(Scalar),
    List { length: Scalar, item: Scalar },
}

impl Kind {
    /// The fewest bytes it takes in binary data.
    fn least_size(self) -> usize {
        match self {
            Self::One(scalar) => scalar.size(),
            Self::List { length, .. } => length.size(),
        }
    }
}

/// What a property is read for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A coordinate of the position, on this axis.
    Position(usize),
    /// A coordinate of the normal, on this axis.
    Normal(usize),
    /// A channel of the colour: red, green, blue.
    Color(usize),
    /// A texture coordinate: to the right, up.
    Texture(usize),
    /// A colour that is not one of a vertex.
    OtherColor,
    /// A texture coordinate that is not one of a vertex.
    OtherTexture,
    /// The vertices of a face or strip.
    Corners,
    /// The texture coordinates of a face's corners, two numbers each.
    Wedges,
    /// Which of the images that the header names a face shows, from 0.
    ImageNumber,
    Other,
}

impl Role {
    fn of(element: ElementKind, name: &[u8], kind: Kind) -> Self {
        let is_list = matches!(kind, Kind::List { .. });
        match (element, name) {
            (ElementKind::Vertex, b"x") if !is_list => Self::Position(0),
            (ElementKind::Vertex, b"y") if !is_list => Self::Position(1),
            (ElementKind::Vertex, b"z") if !is_list => Self::Position(2),
            (ElementKind::Vertex, b"nx") if !is_list => Self::Normal(0),
            (ElementKind::Vertex, b"ny") if !is_list => Self::Normal(1),
            (ElementKind::Vertex, b"nz") if !is_list => Self::Normal(2),
            (ElementKind::Face | ElementKind::Strips, b"vertex_indices" | b"vertex_index")
                if is_list =>
            {
                Self::Corners
            }
            (ElementKind::Face, b"texcoord") if is_list => Self::Wedges,
            (ElementKind::Face, b"texnumber") if !is_list => Self::ImageNumber,
            (ElementKind::Vertex, _) if !is_list => {
                let color = COLORS.iter().position(|names| names.contains(&name));
                let texture = TEXTURES.iter().position(|names| names.contains(&name));
                let role = color.map(Self::Color).or(texture.map(Self::Texture));
                role.unwrap_or(Self::Other)
            }
            _ if COLORS[0].contains(&name) => Self::OtherColor,
            _ if TEXTURES[0].contains(&name) || name == b"texcoord" => Self::OtherTexture,
            _ => Self::Other,
        }
    }
}

/// What programs call red, green and blue.
const COLORS: [&[&[u8]]; 3] = [
    &[b"red", b"r", b"diffuse_red"],
    &[b"green", b"g", b"diffuse_green"],
    &[b"blue", b"b", b"diffuse_blue"],
];
/// What programs call the texture coordinates to the right and up.
const TEXTURES: [&[&[u8]]; 2] = [
    &[b"s", b"u", b"texture_s", b"texture_u"],
    &[b"t", b"v", b"texture_t", b"texture_v"],
];

/// A property of the items of an element.
#[derive(Clone, Copy, Debug)]
pub struct Property {
    pub kind: Kind,
    pub role: Role,
    /// The line of the header that announces it.
    pub line: u64,
}

/// What an element's items are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ElementKind {
    Vertex,
    Face,
    Strips,
    Other,
}

impl ElementKind {
    fn of(name: &[u8]) -> Self {
        match name {
            b"vertex" => Self::Vertex,
            b"face" => Self::Face,
            b"tristrips" => Self::Strips,
            _ => Self::Other,
        }
    }

    /// What one of them is called in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Vertex => "vertex",
            Self::Face => "face",
            Self::Strips => "strip",
            Self::Other => "item",
        }
    }
}

/// A part of the data: items of the same properties, one after the other.
#[derive(Clone, Debug)]
pub struct Element {
    pub kind: ElementKind,
    pub count: u64,
    pub properties: Vec<Property>,
    /// The line of the header that announces it.
    pub line: u64,
}

impl Element {
    /// Whether one of its properties is read for this.
    pub fn has(&self, role: Role) -> bool {
        self.properties.iter().any(|property| property.role == role)
    }

    /// The fewest bytes that an item takes in binary data.
    pub fn least_size(&self) -> usize {
        let sizes = self.properties.iter();
        sizes.map(|property| property.kind.least_size()).sum()
    }

    /// Says what is missing for it to be read.
    fn check(&self) -> Result<(), Malformed> {
        let axes = ["x", "y", "z"].into_iter().enumerate();
        let mut missing = axes.filter(|&(axis, _)| !self.has(Role::Position(axis)));
        match self.kind {
            _ if self.count == 0 => Ok(()),
            ElementKind::Vertex => match missing.next() {
                None => Ok(()),
                Some((_, axis)) => Err(Malformed::in_line(
                    self.line,
                    "vertices with the properties x, y and z",
                    format!("no {axis}"),
                )),
            },
            ElementKind::Face | ElementKind::Strips if !self.has(Role::Corners) => {
                let expected = format!("a list vertex_indices in each {}", self.kind.name());
                Err(Malformed::in_line(self.line, expected, "none"))
            }
            _ => Ok(()),
        }
    }
}

/// How the data is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// The header, checked: what it announces can be read if it is there.
#[derive(Debug)]
pub struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// The images that comments name, as `MeshLab` writes them: `comment TextureFile wood.png`.
    pub images: Vec<String>,
    /// Where the data begins, in bytes.
    pub body: usize,
}

/// Most images of a file.
const MOST_IMAGES: usize = 10_000;

impl Header {
    /// Whether faces have texture coordinates of their own.
    pub fn has_wedges(&self) -> bool {
        let mut elements = self.elements.iter();
        elements.any(|element| element.count > 0 && element.has(Role::Wedges))
    }

    /// Reads the header, after which the cursor is at the end of its last line.
    ///
    /// # Errors
    /// The first line that is not one of a header.
    pub fn read(cursor: &mut Cursor) -> Result<Self, Malformed> {
        const FIRST: &str = "ply in the first line";
        let first = cursor.word().unwrap_or_default();
        if first != b"ply" {
            return Err(Malformed::at_token(1, FIRST, first));
        }
        end_of_line(cursor, "ply")?;
        let pairs_line_ends = cursor.line_end() == b"\r\n";
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        let mut images = Vec::new();
        loop {
            if !cursor.find_word() {
                return Err(Malformed::in_line(
                    cursor.line(),
                    "end_header",
                    "the end of the file",
                ));
            }
            let line = cursor.line();
            match cursor.word().unwrap_or_default() {
                b"comment" | b"obj_info" => {
                    let image = image_in(cursor.rest_of_line());
                    images.extend(image.filter(|_| images.len() < MOST_IMAGES));
                }
                b"format" => encoding = Some(read_encoding(cursor)?),
                b"element" => elements.push(read_element(cursor)?),
                b"property" => {
                    let Some(element) = elements.last_mut() else {
                        let expected = "an element before its first property";
                        return Err(Malformed::in_line(line, expected, "none"));
                    };
                    let property = read_property(cursor, element)?;
                    element.properties.push(property);
                }
                b"end_header" => break,
                word => {
                    let expected = "format, comment, obj_info, element, property or end_header";
                    return Err(Malformed::at_token(line, expected, word));
                }
            }
        }
        let Some(encoding) = encoding else {
            let expected = "a line with the format before end_header";
            return Err(Malformed::in_line(cursor.line(), expected, "none"));
        };
        end_of_line(cursor, "end_header")?;
        check(&elements)?;
        let mut line_end = cursor.line_end();
        if line_end == b"\r\n" && !pairs_line_ends {
            // The data begins with the byte that means a new line elsewhere.
            line_end = b"\r";
        }
        Ok(Self {
            encoding,
            elements,
            images,
            body: cursor.position() + line_end.len(),
        })
    }
}

/// The image that a comment names, if it does.
fn image_in(comment: &[u8]) -> Option<String> {
    const KEYWORD: &[u8] = b"TextureFile";
    let (keyword, name) = comment.split_at_checked(KEYWORD.len())?;
    let is_image = keyword.eq_ignore_ascii_case(KEYWORD) && name.starts_with(b" ");
    let name = name.trim_ascii();
    (is_image && !name.is_empty()).then(|| String::from_utf8_lossy(name).into_owned())
}

/// Says what keeps the elements from being read one after the other.
fn check(elements: &[Element]) -> Result<(), Malformed> {
    let mut has_vertices = false;
    for element in elements {
        element.check()?;
        match element.kind {
            ElementKind::Vertex if has_vertices => {
                let expected = "one element vertex";
                return Err(Malformed::in_line(element.line, expected, "another"));
            }
            ElementKind::Vertex => has_vertices = true,
            ElementKind::Face | ElementKind::Strips if element.count > 0 && !has_vertices => {
                let expected = format!("the element vertex before each {}", element.kind.name());
                return Err(Malformed::in_line(element.line, expected, "none"));
            }
            _ => {}
        }
    }
    Ok(())
}

fn read_encoding(cursor: &mut Cursor) -> Result<Encoding, Malformed> {
    let word = cursor.word().unwrap_or_default();
    let encoding = match word {
        b"ascii" => Encoding::Text,
        b"binary_little_endian" => Encoding::LittleEndian,
        b"binary_big_endian" => Encoding::BigEndian,
        _ => {
            let expected = "the format ascii, binary_little_endian or binary_big_endian";
            return Err(Malformed::at_token(cursor.line(), expected, word));
        }
    };
    // The version: there is only one.
    cursor.rest_of_line();
    Ok(encoding)
}

fn read_element(cursor: &mut Cursor) -> Result<Element, Malformed> {
    let line = cursor.line();
    let name = name(cursor, "element")?;
    let kind = ElementKind::of(name);
    let word = cursor.word().unwrap_or_default();
    let count = whole(word)
        .ok_or_else(|| Malformed::at_token(line, "the number of the element's items", word))?;
    if kind == ElementKind::Vertex && count > u64::from(u32::MAX) {
        return Err(Malformed::at_token(line, "fewer than 2^32 vertices", word));
    }
    end_of_line(cursor, "the element")?;
    Ok(Element {
        kind,
        count,
        properties: Vec::new(),
        line,
    })
}

fn read_property(cursor: &mut Cursor, element: &Element) -> Result<Property, Malformed> {
    let line = cursor.line();
    let word = cursor.word().unwrap_or_default();
    let kind = if word == b"list" {
        let length = cursor.word().unwrap_or_default();
        let item = cursor.word().unwrap_or_default();
        Kind::List {
            length: scalar(line, length)?,
            item: scalar(line, item)?,
        }
    } else {
        Kind::One(scalar(line, word)?)
    };
    let name = name(cursor, "property")?;
    end_of_line(cursor, "the property")?;
    let role = Role::of(element.kind, name, kind);
    // The first of its kind counts.
    let counts_once = matches!(role, Role::Corners | Role::Wedges | Role::ImageNumber);
    let is_new = !counts_once || !element.has(role);
    Ok(Property {
        kind,
        role: if is_new { role } else { Role::Other },
        line,
    })
}

fn scalar(line: u64, word: &[u8]) -> Result<Scalar, Malformed> {
    let expected = "a type: char, uchar, short, ushort, int, uint, float or double";
    Scalar::of(word).ok_or_else(|| Malformed::at_token(line, expected, word))
}

fn name<'a>(cursor: &mut Cursor<'a>, of: &str) -> Result<&'a [u8], Malformed> {
    let line = cursor.line();
    cursor.word().ok_or_else(|| {
        Malformed::in_line(line, format!("the name of the {of}"), "the end of the line")
    })
}

fn end_of_line(cursor: &mut Cursor, after: &str) -> Result<(), Malformed> {
    let line = cursor.line();
    match cursor.word() {
        None => {
            cursor.rest_of_line();
            Ok(())
        }
        Some(word) => {
            let expected = format!("the end of the line after {after}");
            Err(Malformed::at_token(line, expected, word))
        }
    }
}
