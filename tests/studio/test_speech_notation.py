"""Phonemes read from X-SAMPA, the IPA, ARPABET and Praat TextGrids."""

from __future__ import annotations

import pytest

from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.studio.speech import parse_phonemes, read_textgrid
from abs_engine.studio.speech.chart import IPA, X_SAMPA
from abs_engine.studio.speech.notation import spell


def labels(utterance):
    return [segment.phoneme.label for segment in utterance.segments]


def times(utterance):
    return [(s.phoneme.label, round(s.start, 6), round(s.end, 6)) for s in utterance.segments]


@pytest.mark.parametrize(
    ("alphabet", "text", "expected"),
    [
        ("x-sampa", '"{p@l t_Si:z', "æ p ə l t͡ʃ iː z"),
        ("ipa", "ˈæpəl t͡ʃiːz", "æ p ə l t͡ʃ iː z"),
        ("x-sampa", "bO~ZuR 2y9~ _ Ha", "b ɔ̃ ʒ u ʁ ø y œ̃ _ ɥ a"),
        ("ipa", "bɔ̃ʒuʁ øyœ̃ _ ɥa", "b ɔ̃ ʒ u ʁ ø y œ̃ _ ɥ a"),
        ("ipa", "ça tʰʷo", "ç a tʰʷ o"),  # composed or not, a cedilla is part of the letter
        ("x-sampa", "t_h_wo b_<a J\\_<", "tʰʷ o ɓ a ʄ"),
        ("x-sampa", "k_pa p_fa", "k͡p a p f a"),  # at once, and one after the other
        ("arpabet", "HH AH0 L OW1 CH ER2", "h ə l o ʊ̯ t͡ʃ ɜ˞"),
    ],
)
def test_transcriptions(alphabet, text, expected):
    assert labels(parse_phonemes(text, alphabet)) == expected.split()


def test_every_symbol_of_the_chart_is_read_by_itself():
    for alphabet, chart in (("ipa", IPA), ("x-sampa", X_SAMPA)):
        for symbol, phoneme in chart.items():
            assert spell(symbol, alphabet) == (phoneme,)


@pytest.mark.parametrize(
    ("alphabet", "inventory"),
    [
        ("x-sampa", "p b t d k g m n N f v T D s z S Z h t_S d_Z r\\ j w l I e { Q V U @ i: 3: O:"),
        ("ipa", "p b t d k ɡ m n ɲ ŋ f v s z ʃ ʒ ʁ l j w ɥ i y u e ø o ə ɛ œ ɔ a ɑ ɛ̃ œ̃ ɔ̃ ɑ̃"),
    ],
)
def test_english_and_french_are_covered(alphabet, inventory):
    for symbol in inventory.split():
        assert len(spell(symbol, alphabet)) == 1


def test_features_follow_the_marks():
    (plain,) = spell("t", "ipa")
    (round_,) = spell("tʷ", "ipa")
    (lowered,) = spell("e_o", "x-sampa")
    (stressed,) = spell("ˈa", "ipa")
    assert round_.rounding > plain.rounding == 0
    assert lowered.height < IPA["e"].height
    assert (stressed.stress, stressed.label) == (2, "a")
    assert spell("m", "ipa")[0].closes_lips
    assert not spell("ɸ", "ipa")[0].closes_lips
    assert spell("k͡p", "ipa")[0].closes_lips
    assert spell("v", "ipa")[0].touches_teeth


def test_durations_and_times():
    utterance = parse_phonemes("a(0.2) p(0.05) i(0.4-0.55) _(0.1s)")
    assert times(utterance) == [
        ("a", 0, 0.2), ("p", 0.2, 0.25), ("_", 0.25, 0.4), ("i", 0.4, 0.55), ("_", 0.55, 0.65)
    ]  # fmt: skip


def test_sounds_in_a_token_share_its_time_as_by_default():
    # By default p lasts 0.09 s and a 0.11 s, long 1.6 times that.
    utterance = parse_phonemes("pa:(0.532)")
    assert times(utterance) == [("p", 0, 0.18), ("aː", 0.18, 0.532)]
    assert parse_phonemes("pa:").seconds == pytest.approx(0.09 + 1.6 * 0.11)


@pytest.mark.parametrize(
    ("text", "alphabet", "named"),
    [
        ("a S", "ipa", "'S' is not in the IPA"),
        ("aʒж", "ipa", "nearest: 'ʒ'"),
        ("^", "x-sampa", "not in X-SAMPA"),
        ("AA QQ", "arpabet", "nearest: 'Q'"),
        ("", "ipa", "nothing to say"),
        ("   ", "x-sampa", "nothing to say"),
        ("a(-0.1)", "ipa", "not positive"),
        ("a(0)", "ipa", "not positive"),
        ("a(0.3-0.2)", "ipa", "not positive"),
        ("a(x)", "ipa", "not a duration"),
        ("a()", "ipa", "not a duration"),
        ("a(0.2", "ipa", "with a duration"),
        ("a(0.2) p(0.1-0.3)", "ipa", "ends at 0.2 s"),
        ("a", "klingon", "no phonetic alphabet"),
        ("ˈ", "ipa", "not in the IPA"),
        ("t͡", "ipa", "not in the IPA"),
    ],
)
def test_bad_phonemes_are_refused_in_one_line(text, alphabet, named):
    with pytest.raises(ParameterError, match="; ") as caught:
        parse_phonemes(text, alphabet)
    assert named in str(caught.value)
    assert "\n" not in str(caught.value)


def grid(*tiers, seconds=0.6, begin=0.0):
    """A TextGrid in Praat's long text format; tiers are (name, [(start, end, label), ...])."""
    lines = ['File type = "ooTextFile"', 'Object class = "TextGrid"', "", f"xmin = {begin}"]
    lines += [f"xmax = {seconds}", "tiers? <exists>", f"size = {len(tiers)}", "item []:"]
    for number, (name, spans) in enumerate(tiers, 1):
        lines += [f"    item [{number}]:", '        class = "IntervalTier"']
        lines += [
            f'        name = "{name}"',
            f"        xmin = {begin}",
            f"        xmax = {seconds}",
        ]
        lines += [f"        intervals: size = {len(spans)}"]
        for index, (start, end, label) in enumerate(spans, 1):
            lines += [f"        intervals [{index}]:", f"            xmin = {start}"]
            lines += [f"            xmax = {end}", f'            text = "{label}"']
    return "\n".join(lines) + "\n"


PHONES = [(0, 0.1, "sil"), (0.1, 0.2, "p"), (0.2, 0.4, "a:"), (0.4, 0.5, "")]
WORDS = [(0, 0.1, ""), (0.1, 0.4, "pa"), (0.4, 0.6, "")]
SPOKEN = [("_", 0, 0.1), ("p", 0.1, 0.2), ("aː", 0.2, 0.4), ("_", 0.4, 0.6)]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
@pytest.mark.parametrize("name", ["phones", "MAU", "Bob - phonemes"])
def test_the_tier_of_phonemes_is_found(tmp_path, name, encoding):
    path = tmp_path / "said.TextGrid"
    path.write_text(grid(("words", WORDS), (name, PHONES)), encoding)
    assert times(read_textgrid(path)) == SPOKEN


def test_a_tier_can_be_named_and_time_begins_with_the_grid(tmp_path):
    path = tmp_path / "said.TextGrid"
    late = [(start + 2, end + 2, label) for start, end, label in PHONES]
    path.write_text(grid(("mine", late), ("other", late[:1]), seconds=2.6, begin=2.0))
    assert times(read_textgrid(path, "mine")) == SPOKEN


@pytest.mark.parametrize(
    ("spelt", "expected"),
    [("AA1 P IH0", "ɑ p ɪ"), ("ɔ̃ p t͡ʃ", "ɔ̃ p t͡ʃ"), ("O~ p t_S", "ɔ̃ p t͡ʃ")],
)
def test_the_alphabet_is_guessed(tmp_path, spelt, expected):
    path = tmp_path / "said.TextGrid"
    spans = [(0.2 * i, 0.2 * (i + 1), label) for i, label in enumerate(spelt.split())]
    path.write_text(grid(("phones", spans)), "utf-8")
    assert labels(read_textgrid(path)) == expected.split()


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("", "not a TextGrid"),
        ("a table, not a grid", "not a TextGrid"),
        (grid(("phones", PHONES))[:-120], "cannot be read"),
        (grid(("phones", [(0, 0.2, "a"), (0.1, 0.3, "p")])), "overlap"),
        (grid(("phones", [(0, 0.3, "a"), (0.3, 0.2, "p")])), "after its end"),
        (grid(("phones", [(0, 0.3, "")])), "is empty"),
        (grid(("one", WORDS), ("two", WORDS)), "name one of one, two"),
    ],
)
def test_bad_grids_are_refused_in_one_line(tmp_path, text, named):
    path = tmp_path / "said.TextGrid"
    path.write_text(text, "utf-8")
    with pytest.raises(InputFileError, match="; ") as caught:
        read_textgrid(path)
    assert named in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_grid_a_missing_tier_and_a_strange_label_are_named(tmp_path):
    path = tmp_path / "said.TextGrid"
    with pytest.raises(InputFileError, match="does not exist"):
        read_textgrid(path)
    path.write_text(grid(("phones", [(0, 0.2, "a"), (0.2, 0.4, "жж")])), "utf-8")
    with pytest.raises(InputFileError, match=r"no interval tier 'phons'.*phones"):
        read_textgrid(path, "phons")
    with pytest.raises(ParameterError, match=r"at 0\.2 s: 'ж' in 'жж'.*nearest: 'ʒ'"):
        read_textgrid(path)
