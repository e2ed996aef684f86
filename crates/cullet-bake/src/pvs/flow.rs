//! Flow through portals: what is seen through a chain of them, clipped ever smaller, until nothing
//! undecided is left.

use super::flood::{FloodInput, FloodScratch, Shaft, flood};
use super::known::Known;
use super::lines::{Found, Line, follow, is_new};
use super::openings::Openings;
use super::polygon::{HalfSpaces, Polygon, separators};
use super::settings::PvsSettings;
use super::unit::UnitResult;
use crate::rows::{clear, has, ones, set};
use cullet_draw::Random;

/// Portals of a chain at the most. What lies behind a longer one is kept.
const MOST_DEPTH: usize = 96;

/// End of a search for a line through a chain of portals.
enum Stab {
    Found,
    Impossible,
    /// Given up.
    Open,
}

/// Work of one cell.
#[derive(Debug)]
pub(super) struct Flow<'a> {
    openings: &'a Openings,
    known: &'a Known,
    settings: &'a PvsSettings,
    cell: u32,
    /// Cells that this one is known to see.
    visible: Vec<u64>,
    /// Cells whose pair with this one is undecided and that no chain reached yet.
    pub(super) wanted: Vec<u64>,
    /// Cells that a chain reached though no line was found.
    kept: Vec<u64>,
    pub(super) found: Found,
    random: Random,
    scratch: FloodScratch,
    /// Wanted cells that are still ahead, for each depth, and what a flood reached.
    ahead: Vec<u64>,
    reached: Vec<u64>,
    /// Cells along a line.
    line: Vec<u32>,
    /// Cells of the chain, this one first.
    chain: Vec<u32>,
    /// Remainders of the portals of the chain between its first and what it reached.
    passes: Vec<Polygon>,
    /// Halves that a search has still to look at.
    split: Vec<[Polygon; 2]>,
}

impl<'a> Flow<'a> {
    pub(super) fn new(openings: &'a Openings, known: &'a Known, settings: &'a PvsSettings) -> Self {
        let (cells, width) = (known.visible.rows(), known.visible.width());
        Self {
            openings,
            known,
            settings,
            cell: 0,
            visible: vec![0; width],
            wanted: vec![0; width],
            kept: vec![0; width],
            found: Found::default(),
            random: Random::new(0, [0; 2]),
            passes: Vec::new(),
            split: Vec::new(),
            scratch: FloodScratch::new(cells),
            ahead: vec![0; width * (MOST_DEPTH + 2)],
            reached: vec![0; width],
            line: Vec::new(),
            chain: Vec::new(),
        }
    }

    /// Turns to a cell and the undecided cells that are its task.
    pub(super) fn begin(&mut self, cell: u32, wanted: &[u64], random: Random) {
        self.cell = cell;
        self.visible.copy_from_slice(self.known.visible.row(cell));
        self.wanted.copy_from_slice(wanted);
        self.kept.fill(0);
        self.found = Found::default();
        self.random = random;
    }

    /// Follows a line through an opening of this cell, and notes what it proves.
    fn try_line(&mut self, line: &Line) {
        let mut cells = std::mem::take(&mut self.line);
        follow(self.openings, line, &mut cells);
        let mut news = false;
        if !cells.is_empty() {
            for &cell in &cells {
                if !has(&self.visible, cell) {
                    set(&mut self.visible, cell);
                    clear(&mut self.wanted, cell);
                    clear(&mut self.kept, cell);
                    news = true;
                }
            }
            if news || is_new(&self.known.visible, &cells) {
                self.found.push(*line, &cells);
            }
        }
        self.line = cells;
    }

    /// Lines through each pair of the cell's openings, as far as they go.
    pub(super) fn local_lines(&mut self) {
        let openings = self.openings;
        let leaving = openings.leaving(self.cell);
        for a in leaving.clone() {
            for b in a + 1..leaving.end {
                for _ in 0..self.settings.local_lines {
                    let start = openings.polygon(a).point(self.random.three());
                    let point = openings.polygon(b).point(self.random.three());
                    if let Some(direction) = (point - start).try_normalize() {
                        self.try_line(&Line { opening: b, point, direction });
                    }
                }
            }
        }
        // Neighbours see each other, also where nothing is beyond.
        for opening in leaving {
            let point = openings.polygon(opening).centre();
            let direction = openings.get(opening).normal;
            self.try_line(&Line { opening, point, direction });
        }
    }

    /// Aims lines at undecided cells next to what is seen, as far as that leads.
    pub(super) fn aim(&mut self) {
        let tries = self.settings.aimed_lines;
        let openings = self.openings;
        let leaving = openings.leaving(self.cell);
        let mut front: Vec<u32> = ones(&self.visible).collect();
        let mut doors = Vec::new();
        while let Some(cell) = front.pop() {
            for target in openings.leaving(cell) {
                let to = openings.get(target).to;
                if !has(&self.wanted, to)
                    || !has(self.known.might.row(openings.get(target).reverse), self.cell)
                {
                    continue;
                }
                doors.clear();
                doors.extend(leaving.clone().filter(|&door| has(self.known.might.row(door), to)));
                if doors.is_empty() {
                    continue;
                }
                let before = self.found.lines.len();
                for k in 0..tries {
                    let door = doors[(k as usize + before) % doors.len()];
                    let point = openings.polygon(door).point(self.random.three());
                    let end = openings.polygon(target).point(self.random.three());
                    let Some(direction) = (end - point).try_normalize() else { continue };
                    self.try_line(&Line { opening: door, point, direction });
                    if !has(&self.wanted, to) {
                        break;
                    }
                }
                if has(&self.visible, to) {
                    front.push(to);
                }
            }
        }
    }

    /// Follows all chains of portals that could lead to something wanted through an opening of the
    /// cell, and notes what is not seen through it.
    pub(super) fn through(&mut self, door: u32, result: &mut UnitResult) {
        let width = self.wanted.len();
        let opening = self.openings.get(door);
        let before: Vec<u64> =
            self.wanted.iter().zip(self.known.might.row(door)).map(|(w, m)| w & m).collect();
        self.ahead[..width].copy_from_slice(&before);
        self.passes.clear();
        let source = *self.openings.polygon(door);
        self.reach(door, opening.to, &source, &source);
        self.ahead[..width].iter_mut().zip(&self.wanted).for_each(|(a, w)| *a &= w);
        if self.ahead[..width].iter().any(|&w| w != 0) {
            self.chain.clear();
            self.chain.extend([self.cell, opening.to]);
            self.descend(1, [door, door], &source, &source);
        }
        let lost = before.iter().zip(&self.wanted).map(|(b, w)| b & w);
        if lost.clone().any(|w| w != 0) {
            result.closed.push(door);
            result.closed_rows.extend(lost);
        }
    }

    /// A chain reached a cell: if it was wanted, looks for a line through what the chain leaves of
    /// its first portal and its last. False where there is none, so that the chain leads nowhere;
    /// else the cell is done with, found or kept.
    fn reach(&mut self, door: u32, to: u32, source: &Polygon, target: &Polygon) -> bool {
        if !has(&self.wanted, to) {
            return true;
        }
        for k in 0..self.settings.chain_lines {
            let (point, end) = match k {
                0 => (source.centre(), target.centre()),
                _ => (source.point(self.random.three()), target.point(self.random.three())),
            };
            let towards = match end == point {
                true => self.openings.get(door).normal,
                false => end - point,
            };
            let Some(direction) = towards.try_normalize() else { continue };
            self.try_line(&Line { opening: door, point, direction });
            if !has(&self.wanted, to) {
                return true;
            }
        }
        match self.stab(door, to, source, target) {
            Stab::Found => return true,
            Stab::Impossible => return false,
            Stab::Open => {}
        }
        clear(&mut self.wanted, to);
        set(&mut self.kept, to);
        true
    }

    /// Looks for a line through the whole chain: cuts source and target in halves, and clips each
    /// pair of halves by what is between them, until nothing is left or a line is found.
    fn stab(&mut self, door: u32, to: u32, source: &Polygon, target: &Polygon) -> Stab {
        if self.passes.is_empty() {
            return Stab::Open;
        }
        let slack = self.openings.tolerance * 1e-3;
        let mut split = std::mem::take(&mut self.split);
        split.clear();
        split.push([*source, *target]);
        let mut left = self.settings.splits;
        let mut result = Stab::Impossible;
        let mut planes = HalfSpaces::NONE;
        'pairs: while let Some([mut s, mut t]) = split.pop() {
            if left == 0 {
                result = Stab::Open;
                break;
            }
            left -= 1;
            for pass in &self.passes {
                separators(&s, pass, false, slack, &mut planes);
                if !t.clip_all(&planes, slack) {
                    continue 'pairs;
                }
                separators(&t, pass, true, slack, &mut planes);
                if !s.clip_all(&planes, slack) {
                    continue 'pairs;
                }
            }
            let point = s.centre();
            if let Some(direction) = (t.centre() - point).try_normalize() {
                self.try_line(&Line { opening: door, point, direction });
                if !has(&self.wanted, to) {
                    result = Stab::Found;
                    break;
                }
            }
            let (a, b) = (s.longest(), t.longest());
            let cut_source = a.length_squared() > b.length_squared();
            let (axis, whole) = if cut_source { (a, s) } else { (b, t) };
            let Some(normal) = axis.try_normalize() else {
                result = Stab::Open;
                break;
            };
            let d = normal.dot(whole.centre());
            for sign in [1.0, -1.0] {
                let mut half = whole;
                if half.clip(normal * sign, d * sign, 0.0) {
                    split.push(if cut_source { [half, t] } else { [s, half] });
                }
            }
        }
        self.split = split;
        result
    }

    /// The wanted cells that lie ahead at `depth - 1` are sought beyond the last of a chain's
    /// openings, `door` being the first: `source` is what is left of that, `pass` of the last.
    fn descend(&mut self, depth: usize, [door, last]: [u32; 2], source: &Polygon, pass: &Polygon) {
        let width = self.wanted.len();
        let openings = self.openings;
        let (tolerance, slack) = (openings.tolerance, openings.tolerance * 1e-3);
        if depth >= MOST_DEPTH {
            for k in 0..width {
                let all = self.ahead[(depth - 1) * width + k] & self.wanted[k];
                self.wanted[k] &= !all;
                self.kept[k] |= all;
            }
            return;
        }
        let cell = openings.get(last).to;
        let first = openings.get(door);
        let mut planes = HalfSpaces::NONE;
        if depth > 1 {
            separators(source, pass, false, slack, &mut planes);
        }
        planes.push(first.normal, first.d);
        if depth > 1 {
            let passed = openings.get(last);
            planes.push(passed.normal, passed.d);
        }
        let shaft = Shaft::new(&planes);
        let (known, reverse) = (self.known, openings.get(last).reverse);
        if depth > 1 {
            let mut reached = std::mem::take(&mut self.reached);
            let ahead = &mut self.ahead[(depth - 1) * width..depth * width];
            let input = FloodInput {
                openings,
                might: &known.might,
                behind: [self.cell, openings.get(last).from],
                shaft: &shaft,
            };
            let any = flood(&input, cell, ahead, &mut reached, &mut self.scratch);
            ahead.copy_from_slice(&reached);
            self.reached = reached;
            if !any {
                return;
            }
        }
        let mut backward = HalfSpaces::NONE;
        for next in openings.leaving(cell) {
            if next == reverse {
                continue;
            }
            let bounds = openings.bounds(next);
            if !shaft.meets(bounds, openings.tolerance32) {
                continue;
            }
            let back = known.might.row(bounds.reverse);
            if !has(back, self.cell) {
                continue;
            }
            let opening = openings.get(next);
            let might = known.might.row(next);
            let mut any = 0;
            for k in 0..width {
                let word = self.ahead[(depth - 1) * width + k] & might[k] & self.wanted[k];
                self.ahead[depth * width + k] = word;
                any |= word;
            }
            if any == 0 || !self.chain.iter().all(|&behind| has(back, behind)) {
                continue;
            }
            let mut target = *openings.polygon(next);
            if !target.clip_all(&planes, tolerance) {
                continue;
            }
            let mut source = *source;
            if !source.clip(-opening.normal, -opening.d, tolerance) {
                continue;
            }
            if depth > 1 {
                separators(&target, pass, true, slack, &mut backward);
                if !source.clip_all(&backward, tolerance) {
                    continue;
                }
            }
            if !self.reach(door, opening.to, &source, &target) {
                continue;
            }
            let mut more = 0;
            for k in 0..width {
                self.ahead[depth * width + k] &= self.wanted[k];
                more |= self.ahead[depth * width + k];
            }
            if more != 0 && !self.chain.contains(&opening.to) {
                self.chain.push(opening.to);
                self.passes.push(target);
                self.descend(depth + 1, [door, next], &source, &target);
                self.passes.pop();
                self.chain.pop();
            }
        }
    }
}
