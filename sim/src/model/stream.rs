//! The cells at the ends of a stage: register slice, queue, ingress, admission, egress.

use hwgen_spec::design::Port;
use hwgen_spec::quantize::InputFormat;

use super::probe::{Probe, address_bits, counter_bits, within};

/// `hwg_slice`: a word is a few fields.
#[derive(Clone, Debug)]
pub(super) struct Slice {
    fields: usize,
    slot_widths: Vec<u32>,
    /// The head, and the word behind it.
    slots: Vec<i64>,
    valid: bool,
    /// Fewer than two words are held: `ready_q`, unless the last edge was one in reset.
    room: bool,
    ready: bool,
}

impl Slice {
    /// `widths`: of the fields of a word, the lowest first.
    pub(super) fn new(widths: &[u32]) -> Self {
        Self {
            fields: widths.len(),
            slot_widths: widths.repeat(2),
            slots: vec![0; widths.len() * 2],
            valid: false,
            room: false,
            ready: false,
        }
    }

    #[inline]
    pub(super) fn valid(&self) -> bool {
        self.valid
    }

    #[inline]
    pub(super) fn ready(&self) -> bool {
        self.ready
    }

    #[inline]
    pub(super) fn room(&self) -> bool {
        self.room
    }

    /// The fields of the head.
    #[inline]
    pub(super) fn head(&self) -> &[i64] {
        &self.slots[..self.fields]
    }

    /// `put` writes the fields of what is offered, be it a word or not.
    #[inline]
    pub(super) fn step(
        &mut self,
        reset: bool,
        offered: bool,
        taken: bool,
        put: impl Fn(&mut [i64]),
    ) {
        let pop = self.valid && taken;
        let two = self.valid && !self.ready;
        let (head, behind) = self.slots.split_at_mut(self.fields);
        if pop || !self.valid {
            if self.ready {
                put(head);
            } else {
                head.copy_from_slice(behind);
            }
        }
        if self.ready {
            put(behind);
        }
        let two_next = self.valid && !pop && (two || offered);
        // Data moves whatever the reset does; the handshake does not let it be seen.
        self.valid = !reset && (two || (offered && self.ready) || (self.valid && !pop));
        self.room = !two_next;
        self.ready = !reset && self.room;
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        probe.fields("slot_q", &self.slot_widths, &self.slots);
        probe.bit("valid_q", self.valid);
        probe.bit("ready_q", self.ready);
    }
}

/// `hwg_count`.
#[derive(Clone, Debug)]
pub(super) struct Count {
    most: usize,
    start: usize,
    count: usize,
}

impl Count {
    /// Zero at power-up, `start` behind a reset.
    pub(super) fn new(most: usize, start: usize) -> Self {
        Self {
            most,
            start,
            count: 0,
        }
    }

    #[inline]
    pub(super) fn some(&self) -> bool {
        self.count > 0
    }

    #[inline]
    pub(super) fn more(&self) -> bool {
        self.count > 1
    }

    #[inline]
    fn all(&self) -> bool {
        self.count == self.most
    }

    #[inline]
    pub(super) fn step(&mut self, reset: bool, up: bool, down: bool) {
        self.count = if reset {
            self.start
        } else {
            self.count + usize::from(up) - usize::from(down)
        };
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        probe.count("count_q", counter_bits(self.most), self.count);
        probe.bit("some_q", self.some());
        probe.bit("more_q", self.more());
    }
}

/// `hwg_queue`: a word is a few fields.
#[derive(Clone, Debug)]
pub(super) struct Queue {
    widths: Vec<u32>,
    head: Vec<i64>,
    /// Those behind the head: `[word][field]`.
    memory: Vec<i64>,
    write: usize,
    read: usize,
    count: Count,
    ready: bool,
    depth: usize,
}

impl Queue {
    /// `widths`: of the fields of a word, the lowest first.
    pub(super) fn new(widths: &[u32], depth: usize) -> Self {
        Self {
            widths: widths.to_vec(),
            head: vec![0; widths.len()],
            memory: vec![0; widths.len() * (depth - 1)],
            write: 0,
            read: 0,
            count: Count::new(depth, 0),
            ready: false,
            depth,
        }
    }

    /// The fields of the head.
    #[inline]
    pub(super) fn head(&self) -> &[i64] {
        &self.head
    }

    /// `put` writes the fields of the word that is offered.
    #[inline]
    pub(super) fn step(
        &mut self,
        reset: bool,
        offered: bool,
        taken: bool,
        mut put: impl FnMut(&mut [i64]),
    ) {
        let fields = self.widths.len();
        let (valid, more) = (self.count.some(), self.count.more());
        let (push, pop) = (offered && self.ready, valid && taken);
        let behind = push && valid && (more || !taken);
        let moves_up = taken || !valid;
        if moves_up && more {
            let next = &self.memory[self.read * fields..][..fields];
            self.head.copy_from_slice(next);
        }
        // Where there is room, what is offered is written, be it a word or not; without a word behind it the
        // head takes it likewise.
        if self.ready {
            put(&mut self.memory[self.write * fields..][..fields]);
        }
        if moves_up && !more {
            put(&mut self.head);
        }
        let next = |at: usize, moves: bool| (at + usize::from(moves)) % (self.depth - 1);
        (self.write, self.read) = if reset {
            (0, 0)
        } else {
            (next(self.write, behind), next(self.read, pop && more))
        };
        self.count.step(reset, push, pop);
        self.ready = !reset && !self.count.all();
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        probe.fields("head_q", &self.widths, &self.head);
        probe.count("write_q", address_bits(self.depth - 1), self.write);
        probe.count("read_q", address_bits(self.depth - 1), self.read);
        within(probe, format_args!("u_count"), |p| self.count.show(p));
        probe.bit("ready_q", self.ready);
        for (i, word) in self.memory.chunks(self.widths.len()).enumerate() {
            within(probe, format_args!("g_word[{i}]"), |probe| {
                probe.fields("word", &self.widths, word);
            });
        }
    }
}

/// `hwg_ingress`.
#[derive(Clone, Debug)]
pub(super) struct Ingress {
    input: InputFormat,
    lane_bits: u32,
    beat_words: usize,
    beats: usize,
    slice: Slice,
    index: usize,
    /// The beat that has met its bounds.
    bound: Beat,
    /// The beat that was compared with them.
    compared: Beat,
    /// The beat whose words are within them.
    within: Within,
    /// Whether there was an edge: at power-up nothing moves.
    awake: bool,
    /// Whether beats ever moved on: until then no beat enables any words.
    moved: bool,
    words: Vec<i64>,
    full: bool,
    clipped: bool,
    error: bool,
}

/// A beat ready for the frame.
#[derive(Clone, Debug)]
struct Within {
    valid: bool,
    last: bool,
    number: usize,
    /// Not the beat that should be the last.
    short: bool,
    clipped: bool,
    words: Vec<i64>,
}

/// A beat on its way into a frame.
#[derive(Clone, Debug)]
struct Beat {
    valid: bool,
    last: bool,
    /// Its number in the frame.
    number: usize,
    lanes: Vec<Lane>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Lane {
    value: i64,
    low: i64,
    high: i64,
    /// Whether the lane carries a word.
    used: bool,
}

impl Beat {
    fn new(lanes: usize) -> Self {
        Self {
            valid: false,
            last: false,
            number: 0,
            lanes: vec![Lane::default(); lanes],
        }
    }
}

impl Lane {
    fn below(&self) -> bool {
        self.value < self.low
    }

    fn above(&self) -> bool {
        self.value > self.high
    }
}

impl Ingress {
    pub(super) fn new(input: &InputFormat, beat_words: usize, lane_bits: u32) -> Self {
        let words = input.low.len();
        let mut widths = vec![lane_bits; beat_words];
        widths.push(1);
        Self {
            input: input.clone(),
            lane_bits,
            beat_words,
            beats: words.div_ceil(beat_words),
            slice: Slice::new(&widths),
            index: 0,
            bound: Beat::new(beat_words),
            compared: Beat::new(beat_words),
            within: Within {
                valid: false,
                last: false,
                number: 0,
                short: false,
                clipped: false,
                words: vec![0; beat_words],
            },
            awake: false,
            moved: false,
            words: vec![0; words],
            full: false,
            clipped: false,
            error: false,
        }
    }

    #[inline]
    pub(super) fn ready(&self) -> bool {
        self.slice.ready()
    }

    #[inline]
    pub(super) fn full(&self) -> bool {
        self.full
    }

    #[inline]
    pub(super) fn words(&self) -> &[i64] {
        &self.words
    }

    #[inline]
    pub(super) fn clipped(&self) -> bool {
        self.clipped
    }

    #[inline]
    pub(super) fn error(&self) -> bool {
        self.error
    }

    #[inline]
    pub(super) fn step(
        &mut self,
        (reset, quiet): (bool, bool),
        (valid, last, data): (bool, bool, &[i64]),
        frame_ready: bool,
    ) {
        let room = self.room(frame_ready);
        let moves = self.moves(frame_ready);
        self.awake = true;
        let takes = self.slice.valid() && moves;
        let puts = self.within.valid && room;
        self.full = !reset && (puts && self.within.last || self.full && !frame_ready);
        if puts {
            self.put();
        }
        if moves {
            self.advance();
        }
        if takes {
            let ends = self.slice.head()[self.beat_words] != 0;
            self.index = if ends {
                0
            } else {
                (self.index + 1).min(self.beats)
            };
        }
        if reset {
            self.index = 0;
            self.bound.valid = false;
            self.compared.valid = false;
            self.within.valid = false;
        }
        let beat_words = self.beat_words;
        self.slice.step(quiet, valid, moves, |slot| {
            slot[..beat_words].copy_from_slice(data);
            slot[beat_words] = i64::from(last);
        });
    }

    /// `room_q`: no frame stands here, or the one that does starts now.
    #[inline]
    fn room(&self, frame_ready: bool) -> bool {
        self.awake && (!self.full || frame_ready)
    }

    /// `move_q`
    #[inline]
    fn moves(&self, frame_ready: bool) -> bool {
        self.awake && (!self.within.valid || self.room(frame_ready))
    }

    /// The beat that is within its bounds goes into the frame.
    fn put(&mut self) {
        let beat = &self.within;
        let first = beat.number == 0;
        if first {
            self.words.copy_from_slice(&self.input.low);
        }
        let base = beat.number * self.beat_words;
        for (own, word) in self.words.iter_mut().skip(base).zip(&beat.words) {
            *own = *word;
        }
        self.clipped = (self.clipped && !first) || beat.clipped;
        self.error = beat.short;
    }

    /// All beats move on by a stage.
    fn advance(&mut self) {
        let (within, compared) = (&mut self.within, &self.compared);
        within.valid = compared.valid;
        within.last = compared.last;
        within.number = compared.number;
        within.short = compared.number != self.beats - 1;
        within.clipped = false;
        for (word, lane) in within.words.iter_mut().zip(&compared.lanes) {
            within.clipped |= lane.used && (lane.below() || lane.above());
            *word = if lane.below() {
                lane.low
            } else if lane.above() {
                lane.high
            } else {
                lane.value
            };
        }
        self.moved = true;
        std::mem::swap(&mut self.bound, &mut self.compared);
        let head = self.slice.head();
        let input = &self.input;
        let bound = &mut self.bound;
        bound.valid = self.slice.valid();
        bound.last = head[self.beat_words] != 0;
        bound.number = self.index;
        let base = self.index * self.beat_words;
        for (at, (lane, value)) in bound.lanes.iter_mut().zip(head).enumerate() {
            let bounds = input.low.get(base + at).zip(input.high.get(base + at));
            *lane = Lane {
                value: *value,
                low: bounds.map_or(0, |(low, _)| *low),
                high: bounds.map_or(0, |(_, high)| *high),
                used: bounds.is_some(),
            };
        }
    }

    /// `frame_ready`: whether a frame that stands here starts in this clock.
    pub(super) fn show<P: Probe>(&self, frame_ready: bool, probe: &mut P) {
        within(probe, format_args!("u_slice"), |p| self.slice.show(p));
        probe.bit("room_q", self.room(frame_ready));
        probe.bit("move_q", self.moves(frame_ready));
        let (bits, width) = (counter_bits(self.beats), self.input.format.width());
        let (bound, compared, inside) = (&self.bound, &self.compared, &self.within);
        probe.count("index_q", bits, self.index);
        probe.count("beat_q", bits, bound.number);
        probe.count("beat_q2", bits, compared.number);
        let enables = |beat| self.moved && (inside.number == 0 || inside.number == beat);
        let enables: Vec<_> = (0..self.beats).map(|b| i64::from(enables(b))).collect();
        probe.words("enable_q3", 1, &enables);
        let puts = inside.valid && self.room(frame_ready);
        let writes: Vec<_> = enables.iter().map(|e| e & i64::from(puts)).collect();
        probe.bit("put_q", puts);
        probe.words("write_q", 1, &writes);
        probe.bit("valid_q", bound.valid);
        probe.bit("valid_q2", compared.valid);
        probe.bit("last_q", bound.last);
        probe.bit("last_q2", compared.last);
        probe.bit("valid_q3", inside.valid);
        probe.bit("last_q3", inside.last);
        probe.bit("short_q3", inside.short);
        probe.bit("clip_q3", inside.clipped);
        for (j, (first, second)) in bound.lanes.iter().zip(&compared.lanes).enumerate() {
            within(probe, format_args!("g_lane[{j}]"), |probe| {
                probe.word("value_q", self.lane_bits, first.value);
                probe.word("low_q", width, first.low);
                probe.word("high_q", width, first.high);
                probe.bit("used_q", first.used);
                let above = 64 - width;
                probe.word("value_q2", width, second.value << above >> above);
                probe.word("low_q2", width, second.low);
                probe.word("high_q2", width, second.high);
                probe.bit("used_q2", second.used);
                probe.bit("below_q2", second.below());
                probe.bit("above_q2", second.above());
                let word = inside.words[j];
                probe.word("word_q3", width, word << above >> above);
            });
        }
        probe.words("word_q", width, &self.words);
        probe.bit("clipped_q", self.clipped);
        probe.bit("error_q", self.error);
    }
}

/// `hwg_admit`.
#[derive(Clone, Debug)]
pub(super) struct Admit {
    interval: usize,
    gap: usize,
    credits: Count,
    ready: bool,
    /// Whether there was an edge: at power-up every register is zero.
    awake: bool,
}

impl Admit {
    pub(super) fn new(interval: usize, credits: usize) -> Self {
        Self {
            interval,
            gap: 0,
            credits: Count::new(credits, credits),
            ready: false,
            awake: false,
        }
    }

    #[inline]
    pub(super) fn ready(&self) -> bool {
        self.ready
    }

    #[inline]
    pub(super) fn step(&mut self, reset: bool, start: bool, release: bool) {
        self.awake = true;
        self.credits.step(reset, release, start);
        self.gap = if reset {
            0
        } else if start {
            self.interval - 1
        } else {
            self.gap.saturating_sub(1)
        };
        self.ready = !reset && self.gap == 0 && self.credits.some();
    }

    pub(super) fn show<P: Probe>(&self, probe: &mut P) {
        probe.count("gap_q", counter_bits(self.interval), self.gap);
        probe.bit("ends_q", self.awake && self.gap <= 1);
        within(probe, format_args!("u_credits"), |p| self.credits.show(p));
    }
}

/// `hwg_egress`.
#[derive(Clone, Debug)]
pub(super) struct Egress {
    /// Whether the last beat makes room for the next frame when it goes on.
    eager: bool,
    lane_bits: u32,
    beat_words: usize,
    beats: usize,
    slots: Vec<i64>,
    left: usize,
    user: i64,
    slice: Slice,
}

impl Egress {
    pub(super) fn new(sink: &Port, eager: bool) -> Self {
        let (beats, beat_words, lane_bits) = (sink.beats(), sink.words_per_beat, sink.lane_bits);
        let mut widths = vec![lane_bits; beat_words];
        widths.extend([2, 1]);
        Self {
            eager,
            lane_bits,
            beat_words,
            beats,
            slots: vec![0; beats * beat_words],
            left: 0,
            user: 0,
            slice: Slice::new(&widths),
        }
    }

    /// Whether a frame would be taken in this clock.
    #[inline]
    pub(super) fn ready(&self) -> bool {
        self.left == 0 || (self.eager && self.left == 1 && self.slice.room())
    }

    /// The beat at the port, if there is one: data, user, last.
    #[inline]
    pub(super) fn beat(&self) -> Option<(&[i64], i64, bool)> {
        let head = self.slice.head();
        let (data, rest) = head.split_at(self.beat_words);
        self.slice.valid().then(|| (data, rest[0], rest[1] != 0))
    }

    /// `put` writes the words of the frame that is loaded.
    #[inline]
    pub(super) fn step(
        &mut self,
        (reset, quiet): (bool, bool),
        load: bool,
        user: i64,
        taken: bool,
        put: impl FnOnce(&mut [i64]),
    ) {
        let sends = self.left != 0;
        let accepted = sends && self.slice.room();
        let (beat_words, last) = (self.beat_words, self.left == 1);
        let (slots, old_user) = (&self.slots, self.user);
        self.slice.step(quiet, sends, taken, |slot| {
            slot[..beat_words].copy_from_slice(&slots[..beat_words]);
            slot[beat_words] = old_user;
            slot[beat_words + 1] = i64::from(last);
        });
        if load {
            self.slots.fill(0);
            put(&mut self.slots);
            self.user = user;
        } else if accepted {
            self.slots.copy_within(beat_words.., 0);
        }
        self.left = match (reset, load) {
            (true, _) => 0,
            (_, true) => self.beats,
            _ => self.left - usize::from(accepted),
        };
    }

    /// `load`: whether a frame comes in this clock.
    pub(super) fn show<P: Probe>(&self, load: bool, probe: &mut P) {
        within(probe, format_args!("u_slice"), |p| self.slice.show(p));
        probe.words("slot_q", self.lane_bits, &self.slots);
        probe.count("left_q", counter_bits(self.beats), self.left);
        let sends = self.left != 0 && self.slice.room();
        probe.bit("load_q", load);
        probe.bit("next_q", sends);
        probe.bit("move_q", load || sends);
        probe.word("user_q", 2, self.user);
    }

    /// The pins of `m_axis`, whether or not there is a beat.
    pub(super) fn show_port<P: Probe>(&self, probe: &mut P) {
        let (data, rest) = self.slice.head().split_at(self.beat_words);
        probe.bit("m_axis_tvalid", self.slice.valid());
        probe.words("m_axis_tdata", self.lane_bits, data);
        probe.word("m_axis_tuser", 2, rest[0]);
        probe.bit("m_axis_tlast", rest[1] != 0);
    }
}
