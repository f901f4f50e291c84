//! Tokens and comments in one row, by place, with what the tree knows of them.

use std::collections::HashSet;

use crate::ast::{self, ItemKind, Member, MemberKind, SceneMember, Solid, SolidKind, TermKind};
use crate::lexer::lex;
use crate::statements::mark;
use crate::token::Token;
use crate::{FileId, Span};

/// How wide a tab is taken to be.
const TAB: usize = 4;

/// A token or a comment.
#[derive(Debug)]
pub(super) struct Piece<'a> {
    /// As it is written, without blanks behind it.
    pub(super) text: &'a str,
    pub(super) kind: Kind,
    /// How many lines end between the piece before it and this one.
    pub(super) lines_before: usize,
    /// Where it stands in its line, in characters from 0.
    pub(super) column: usize,
    /// How many brackets of any kind are open around it.
    pub(super) depth: usize,
    /// The last of these brackets.
    pub(super) around: Option<usize>,
    /// How many blocks of statements are open around it.
    pub(super) block: usize,
    /// Where it stands among statements.
    pub(super) role: Role,
}

/// The kinds of [`Piece`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    Token(Token),
    /// A minus before a value.
    Sign,
    /// A square bracket around a part of a walk, or its partner.
    WalkBracket(Token),
    /// A comment that ends with its line.
    LineComment,
    BlockComment,
}

/// Where a piece stands among statements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// It begins a statement, or is a comment between two.
    Leads,
    /// It opens a block of statements.
    Opens,
    /// It closes one.
    Closes,
    /// Anything else in a statement.
    Within,
}

/// All pieces of a text.
#[derive(Debug)]
pub(super) struct Pieces<'a> {
    pub(super) all: Vec<Piece<'a>>,
    /// For each bracket its partner.
    pub(super) partner: Vec<Option<usize>>,
}

impl Piece<'_> {
    /// Where the line goes on behind it if it begins in this column.
    pub(super) fn end_column(&self, column: usize) -> usize {
        column_behind(self.text, column)
    }

    /// The token, if it is one.
    pub(super) fn token(&self) -> Option<Token> {
        match self.kind {
            Kind::Token(token) | Kind::WalkBracket(token) => Some(token),
            Kind::Sign => Some(Token::Minus),
            Kind::LineComment | Kind::BlockComment => None,
        }
    }

    pub(super) fn is_comment(&self) -> bool {
        matches!(self.kind, Kind::LineComment | Kind::BlockComment)
    }

    /// Whether it belongs to what stands before it, and never apart.
    pub(super) fn is_punctuation(&self) -> bool {
        use Token::{CloseRound, CloseSquare, Colon, Comma, Dot, DotDot, Semicolon};
        matches!(self.kind, Kind::Token(Comma | Semicolon | CloseRound | CloseSquare | Colon | Dot | DotDot))
    }

    /// Whether it joins or cuts solids.
    pub(super) fn is_solid_operator(&self) -> bool {
        matches!(self.token(), Some(Token::Union | Token::Intersect | Token::Subtract))
    }
}

impl<'a> Pieces<'a> {
    /// The pieces of a text without mistakes, of which `tree` is the tree.
    pub(super) fn new(file: FileId, text: &'a str, tree: &ast::File) -> Self {
        let lexed = lex(file, text);
        let statements = mark(file, &lexed.tokens, &mut Vec::new());
        let mut reader = Reader::new(text, walk_brackets(tree));
        let mut comments = lexed.comments.iter().peekable();
        for (start, token, end) in statements.tokens() {
            while let Some(comment) = comments.next_if(|it| it.span.start < start) {
                reader.comment(comment.span);
            }
            match token {
                Token::EndItem | Token::EndMember => reader.end_statement(),
                token => reader.token(token, start, end),
            }
        }
        for comment in comments {
            reader.comment(comment.span);
        }
        Self { all: reader.all, partner: reader.partner }
    }
}

/// Makes the pieces.
struct Reader<'a> {
    text: &'a str,
    walk_brackets: HashSet<u32>,
    all: Vec<Piece<'a>>,
    partner: Vec<Option<usize>>,
    /// The open brackets, and which of them are blocks of statements.
    open: Vec<(usize, bool)>,
    /// The first token of the statement at hand, if one is begun, for each open block and the file.
    statements: Vec<Option<Token>>,
    /// How far the text has been read, and in which column that is.
    read: usize,
    column: usize,
}

impl<'a> Reader<'a> {
    fn new(text: &'a str, walk_brackets: HashSet<u32>) -> Self {
        Self {
            text,
            walk_brackets,
            all: Vec::new(),
            partner: Vec::new(),
            open: Vec::new(),
            statements: vec![None],
            read: 0,
            column: 0,
        }
    }

    fn end_statement(&mut self) {
        if let Some(statement) = self.statements.last_mut() {
            *statement = None;
        }
    }

    fn is_between_statements(&self) -> bool {
        self.statements.last().is_some_and(Option::is_none)
    }

    fn comment(&mut self, span: Span) {
        let is_line = self.text.get(span.start as usize..).is_some_and(|it| it.starts_with("//"));
        let kind = if is_line { Kind::LineComment } else { Kind::BlockComment };
        let role = if self.is_between_statements() { Role::Leads } else { Role::Within };
        self.push(kind, span.start, span.end, role);
    }

    fn token(&mut self, token: Token, start: u32, end: u32) {
        if token.is_closer() {
            return self.close(token, start, end);
        }
        let role = if self.is_between_statements() { Role::Leads } else { Role::Within };
        if let Some(statement) = self.statements.last_mut() {
            statement.get_or_insert(token);
        }
        let opens_block = token == Token::OpenBlock && self.holds_statements();
        let role = if opens_block { Role::Opens } else { role };
        let before = self.all.iter().rev().find_map(Piece::token);
        let kind = match token {
            Token::Minus if !before.is_some_and(Token::ends_value) => Kind::Sign,
            Token::OpenSquare if self.walk_brackets.contains(&start) => Kind::WalkBracket(token),
            _ => Kind::Token(token),
        };
        self.push(kind, start, end, role);
        if token.closer().is_some() || token == Token::OpenBlock {
            self.open.push((self.all.len() - 1, opens_block));
            if opens_block {
                self.statements.push(None);
            }
        }
    }

    fn close(&mut self, token: Token, start: u32, end: u32) {
        let Some((opener, is_block)) = self.open.pop() else { return };
        if is_block {
            self.statements.pop();
        }
        let is_walk = matches!(self.all.get(opener).map(|it| it.kind), Some(Kind::WalkBracket(_)));
        let kind = if is_walk { Kind::WalkBracket(token) } else { Kind::Token(token) };
        self.push(kind, start, end, if is_block { Role::Closes } else { Role::Within });
        let here = self.all.len() - 1;
        self.partner[here] = Some(opener);
        self.partner[opener] = Some(here);
    }

    /// Whether the block that opens now has statements in it: it is a system, a group of rules or the scene.
    fn holds_statements(&self) -> bool {
        let first = self.statements.last().copied().flatten();
        matches!(first, Some(Token::Csg | Token::Shape | Token::Hull | Token::Scene | Token::Priority))
    }

    fn push(&mut self, kind: Kind, start: u32, end: u32, role: Role) {
        let (start, end) = (start as usize, end as usize);
        let gap = self.text.get(self.read..start).unwrap_or_default();
        let lines_before = gap.matches('\n').count();
        let column = column_behind(gap, self.column);
        let written = self.text.get(start..end).unwrap_or_default();
        self.column = column_behind(written, column);
        self.read = end;
        let text = if matches!(kind, Kind::LineComment) { written.trim_end() } else { written };
        let (depth, block) = (self.open.len(), self.statements.len() - 1);
        let around = self.open.last().map(|it| it.0);
        self.all.push(Piece { text, kind, lines_before, column, depth, around, block, role });
        self.partner.push(None);
    }
}

/// The column in which a line goes on, or the last of the lines, behind a text that begins in a column.
fn column_behind(text: &str, column: usize) -> usize {
    let (start, last) = text.rsplit_once('\n').map_or((column, text), |(_, last)| (0, last));
    last.chars().fold(start, |at, letter| at + if letter == '\t' { TAB - at % TAB } else { 1 })
}

/// Where the square brackets of walks begin: with others they share only their shape.
fn walk_brackets(tree: &ast::File) -> HashSet<u32> {
    let mut found = HashSet::new();
    for item in &tree.items {
        match &item.kind {
            ItemKind::System(system) => system.members.iter().for_each(|it| in_member(it, &mut found)),
            ItemKind::Scene(scene) => {
                for member in &scene.members {
                    match member {
                        SceneMember::Show(solid) => in_solid(solid, &mut found),
                        SceneMember::Record { .. } | SceneMember::Error(_) => {}
                    }
                }
            }
            ItemKind::Use { .. }
            | ItemKind::Param(_)
            | ItemKind::Let(_)
            | ItemKind::Fn(_)
            | ItemKind::Enum { .. }
            | ItemKind::Texture { .. }
            | ItemKind::Material { .. }
            | ItemKind::Error => {}
        }
    }
    found
}

fn in_member(member: &Member, found: &mut HashSet<u32>) {
    match &member.kind {
        MemberKind::Start(solid) | MemberKind::Proxy { solid, .. } => in_solid(solid, found),
        MemberKind::Rule(rule) => in_solid(&rule.successor, found),
        MemberKind::Priority { rules, .. } => rules.iter().for_each(|it| in_member(it, found)),
        MemberKind::Let(_)
        | MemberKind::Fn(_)
        | MemberKind::Var(_)
        | MemberKind::Calc { .. }
        | MemberKind::Select { .. }
        | MemberKind::Derive { .. }
        | MemberKind::Prune(_)
        | MemberKind::Error => {}
    }
}

fn in_solid(solid: &Solid, found: &mut HashSet<u32>) {
    match &solid.kind {
        SolidKind::Union(operands) => operands.iter().for_each(|it| in_solid(it, found)),
        SolidKind::Cut { first, rest } => {
            in_solid(first, found);
            rest.iter().for_each(|it| in_solid(&it.1, found));
        }
        SolidKind::Chain(terms) => {
            for term in terms {
                match &term.kind {
                    TermKind::Bracket(solid) => {
                        found.insert(term.span.start);
                        in_solid(solid, found);
                    }
                    TermKind::Group(solid) | TermKind::Repeat { body: solid, .. } => in_solid(solid, found),
                    TermKind::Choice { branches, otherwise } => {
                        branches.iter().for_each(|it| in_solid(&it.1, found));
                        otherwise.iter().for_each(|it| in_solid(it, found));
                    }
                    TermKind::Call { .. } | TermKind::Calc(_) | TermKind::Error => {}
                }
            }
        }
    }
}
