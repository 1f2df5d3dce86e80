"""Speech with the visemes of each moment, by Debian's espeak-ng, festival and flite."""
import ctypes
import subprocess
import tempfile
import wave

import numpy as np

from features import HOP, RATE, WINDOW, log_mel

VISEMES = "sil PP FF TH DD kk CH SS nn RR aa E ih oh ou".split()

# Visemes of IPA's letters; of several, the first that fits. A diphthong is two.
IPA = [
    ("tʃ dʒ tɕ dʑ ʃ ʒ ɕ ʑ ʂ ʐ", "CH"), ("ts dz s z", "SS"), ("θ ð", "TH"), ("p b m ɓ β", "PP"),
    ("f v ɱ ʋ", "FF"), ("t d ʈ ɖ ɗ", "DD"), ("k ɡ g x ɣ h ɦ ŋ c ɟ ç χ ʁ ʔ q ʀ", "kk"),
    ("n l ɲ ʎ ɫ ɳ ɭ", "nn"), ("ɹ r ɾ ɝ ɚ ɜ ɻ", "RR"), ("a ɑ æ ɐ ʌ", "aa"), ("e ɛ ə ɘ", "E"),
    ("i ɪ j ɨ", "ih"), ("o ɔ ɒ ø œ ɵ", "oh"), ("u ʊ w ɯ y ʏ ɥ ʉ", "ou")]
LETTERS = [(letter, viseme) for letters, viseme in IPA for letter in letters.split()]
# Of Festival's and flite's phonemes, less lengths and stresses. Languages differ in a few.
NAMES = dict(
    sil="# pau _", PP="p b m pp bb mm", FF="f v nf", TH="th dh", DD="t d", kk="k g hh ng h x G N",
    CH="ch jh sh zh tS dZ S Z", SS="s z ts dz", nn="n l J L", RR="r er rr R", aa="aa ae ah a A",
    E="ax eh e E @", ih="ih iy y i j I", oh="ao o O", ou="uh uw w u U")
VISEME_OF = {name: viseme for viseme, names in NAMES.items() for name in names.split()}
VISEME_OF.update({"ey": "E ih", "ow": "oh ou", "oy": "oh ih", "aw": "aa ou", "ay": "aa ih"})
CZECH = {"c": "SS", "c~": "CH", "s~": "CH", "z~": "CH", "r~": "CH", "ch": "kk", "d~": "DD",
         "t~": "DD", "n~": "nn", "dz~": "CH"}
FINNISH = {"y": "ou", "oe": "oh", "ae": "aa"}


def visemes_of_ipa(name):
    found = []
    while name:
        for letter, viseme in LETTERS:
            if name.startswith(letter):
                found.append(viseme)
                name = name[len(letter):]
                break
        else:
            name = name[1:]  # length, stress, nasality
    return found[:2]


# How strongly a viseme holds against its neighbours, and how far beyond its segment, seconds.
DOMINANCE = dict(
    sil=(1.0, .05), PP=(30, .012), FF=(8, .018), TH=(1.5, .03), DD=(.7, .025), kk=(.35, .025),
    CH=(3, .035), SS=(1.5, .025), nn=(.6, .03), RR=(1.3, .035), aa=(1.6, .04), E=(1.2, .035),
    ih=(1.3, .035), oh=(2, .045), ou=(2.2, .05))


def weights_of(segments, frames):
    """[(viseme, begin, end)], seconds -> [frames, 15]; time k is the middle of frame k."""
    t = (np.arange(frames) * HOP + WINDOW / 2) / RATE
    total = np.full((frames, len(VISEMES)), 1e-9)
    for viseme, begin, end in segments:
        strength, reach = DOMINANCE[viseme]
        away = np.maximum(0, np.maximum(begin - t, t - end))
        total[:, VISEMES.index(viseme)] += strength * np.exp(-away / reach)
    return total / total.sum(1, keepdims=True)


ESPEAK_CLOSURE = 0.06  # seconds of silence before the burst, where espeak-ng's event of p, t, k is


def segments_of(phonemes, end, closure):
    """[(name, visemes, begin)] -> [(viseme, begin, end)]; closure: seconds before p, t and k."""
    segments = []
    for i, (name, visemes, begin) in enumerate(phonemes):
        stop = phonemes[i + 1][2] if i + 1 < len(phonemes) else end
        if closure and name[:1] in ("p", "t", "k", "c", "q") and segments:
            closed = max(begin - closure, 0.5 * (segments[-1][1] + segments[-1][2]))
            segments[-1] = (*segments[-1][:2], min(segments[-1][2], closed))
            if visemes == ["PP"]:  # the lips are open while breath follows
                stop = min(stop, begin + 0.015)
            begin = closed
        if name in ("h", "ɦ", "ʔ", "hh"):  # of the vowel that follows
            continue
        for k, viseme in enumerate(visemes):
            step = (stop - begin) / len(visemes)
            segments.append((viseme, begin + k * step, begin + (k + 1) * step))
    return segments

# ---------------------------------------------------------------- speakers

WORDS = """
the of and to in is you that it he was for on are as with his they at be this from have or by one
had not but what all were when we there can an your which their said if do will each about how up
out them then she many some so these would other into has more her two like him see time could no
make than first been its who now people my made over did down only way find use may water long
little very after words called just where most know get through back much before go good new write
our used me man too any day same right look think also around another came come work three must
because does part even place well such here take why things help put years different away again off
went old number great tell men say small every found still between name should home big give air
line set own under read last never us left end along while might next sound below saw something
thought both few those always looked show large often together asked house world going want school
important until form food keep children feet land side without boy once animals life enough took
sometimes four head above kind began almost live page got earth need far hand high year mother
light parts country father let night following picture being study second eyes soon times story
boys since white days ever paper hard near sentence better best across during today others however
sure means knew try told young miles sun ways thing whole hear example heard several change answer
room sea against top turned learn point city play toward five using himself usually money seen car
morning body upon family later turn move face door cut done group true half red fish plants living
wanted black eat short run book gave order open ground cold really table remember tree course front
American space inside ago sad early learned brought close nothing though idea before lived became
add become grow draw yet less wind behind cannot letter among able dog shown mean English rest
perhaps certain six feel fire ready green yes built special ran full town complete oh person hot
anything hold state list stood hundred shape ten fast felt kept notice voice power problem map
bubble vivid pepper maybe thumb measure church judge zoo whisper shadow yellow forever of above
vision azure boil join cube view fuel huge bumping member people probably above puppy bamboo mommy
pump bob mop lamb five wife leaf love
""".split()
LANGUAGES = (4 * "en-us " + "en en en-gb-x-rp en-gb-scotland de de fr es it pt nl pl sv").split()
VARIANTS = [""] * 2 + [f"+m{i}" for i in range(1, 9)] + [f"+f{i}" for i in range(1, 6)] + [
    "+Andy", "+Annie", "+Andrea", "+Denis", "+Diogo", "+Gene", "+Jacky", "+Lee", "+linda",
    "+Marco", "+Michael", "+pablo", "+steph", "+Storm", "+belinda", "+adam", "+Mike", "+klatt4"]


class Event(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("identifier", ctypes.c_uint), ("text", ctypes.c_int),
                ("length", ctypes.c_int), ("milliseconds", ctypes.c_int), ("sample", ctypes.c_int),
                ("user", ctypes.c_void_p), ("name", ctypes.c_char * 8)]


class Speaker:
    """espeak-ng's library: text -> samples and phonemes."""

    SYNCHRONOUS, PHONEME_EVENTS, IPA, PHONEME = 2, 1, 2, 7

    def __init__(self):
        self.library = ctypes.CDLL("libespeak-ng.so.1")
        self.rate = self.library.espeak_Initialize(
            self.SYNCHRONOUS, 0, None, self.PHONEME_EVENTS | self.IPA)
        self.sound, self.phonemes = [], []
        callback = ctypes.CFUNCTYPE(
            ctypes.c_int, ctypes.POINTER(ctypes.c_short), ctypes.c_int, ctypes.POINTER(Event))
        self.callback = callback(self._take)
        self.library.espeak_SetSynthCallback(self.callback)

    def _take(self, sound, count, events):
        if sound and count > 0:
            self.sound.append(np.ctypeslib.as_array(sound, (count,)).copy())
        i = 0
        while events[i].type:
            if events[i].type == self.PHONEME:
                name = bytes(events[i].name).split(b"\0")[0].decode("utf-8", "ignore")
                self.phonemes.append((name, events[i].milliseconds / 1000))
            i += 1
        return 0

    def say(self, text, voice, pitch, words_per_minute):
        self.sound, self.phonemes = [], []
        if self.library.espeak_SetVoiceByName(voice.encode()):
            raise SystemExit(f"espeak-ng has no voice {voice}")
        self.library.espeak_SetParameter(1, words_per_minute, 0)
        self.library.espeak_SetParameter(3, pitch, 0)
        data = text.encode() + b"\0"
        self.library.espeak_Synth(data, len(data), 0, 0, 0, 1, None, None)
        x = np.concatenate(self.sound) / 32768.0
        phonemes = []
        for name, begin in self.phonemes:
            if name.startswith("("):
                continue  # of another language
            visemes = visemes_of_ipa(name) or (["sil"] if name in ("", "_", "_:") else [])
            if visemes:
                phonemes.append((name, visemes, begin))
        return resample(x, RATE / self.rate), phonemes


# Recorded people by diphones or statistics: voice, how to load it, what it reads.
FESTIVAL = {
    "kal": ("voice_kal_diphone", "en"), "ked": ("voice_ked_diphone", "en"),
    "slt": ("voice_cmu_us_slt_arctic_hts", "en"), "lp": ("voice_lp_diphone", "it"),
    "pc": ("voice_pc_diphone", "it"), "dita": ("voice_czech_dita", "cs"),
    "krb": ("voice_czech_krb", "cs"), "machac": ("voice_czech_machac", "cs"),
    "ph": ("voice_czech_ph", "cs"), "lj": ("voice_suo_fi_lj_diphone", "fi"),
    "mv": ("voice_hy_fi_mv_diphone", "fi"), "ona": ("voice_upc_ca_ona_hts", "ca")}
FLITE = ("awb", "rms")
FESTIVAL_SAYS = """(define (say voice text file) (eval (list voice))
 (let ((u (utt.synth (eval (list 'Utterance 'Text text)))))
  (utt.save.wave u (string-append file ".wav") 'riff)
  (utt.save.segs u (string-append file ".lab"))))
"""


def visemes_of_name(name, language):
    own = {"cs": CZECH, "fi": FINNISH}.get(language, {})
    for known in (own, VISEME_OF):
        for spelled in (name, name.rstrip("0123456789:~"), name.rstrip("0123456789:~").lower()):
            if spelled in known:
                return known[spelled].split()
    return []


def read_wav(path):
    with wave.open(path) as file:
        x = np.frombuffer(file.readframes(file.getnframes()), np.int16) / 32768.0
        return resample(x, RATE / file.getframerate())


def recordings(sentences):
    """[(speaker, text)] -> [(speaker, samples, [(name, visemes, begin)])]."""
    out = []
    with tempfile.TemporaryDirectory() as folder:
        script = [FESTIVAL_SAYS]
        for i, (speaker, text) in enumerate(sentences):
            if speaker in FESTIVAL:
                script.append(f'(say \'{FESTIVAL[speaker][0]} "{text}" "{folder}/{i}")\n')
        open(f"{folder}/all.scm", "w").write("".join(script))
        subprocess.run(["festival", "-b", f"{folder}/all.scm"], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for i, (speaker, text) in enumerate(sentences):
            names, ends = [], []
            if speaker in FESTIVAL:
                for line in open(f"{folder}/{i}.lab").read().split("\n")[1:]:
                    if line:
                        end, _, name = line.split()[:3]
                        names.append(name), ends.append(float(end))
            else:
                said = subprocess.run(
                    ["flite", "-voice", speaker, "-psdur", "-t", text, "-o", f"{folder}/{i}.wav"],
                    check=True, capture_output=True, text=True).stdout
                for token in said.split():
                    name, end = token.split(":")
                    names.append(name), ends.append(float(end))
            language = language_of(speaker)
            phonemes, begin = [], 0.0
            for name, end in zip(names, ends):
                visemes = visemes_of_name(name, language)
                if not visemes:
                    raise SystemExit(f"{speaker}: no viseme of '{name}' in '{text}'")
                phonemes.append((name, visemes, begin))
                begin = end
            out.append((speaker, read_wav(f"{folder}/{i}.wav"), phonemes))
    return out


SYLLABLES = dict(
    it=("p b m f v t d n l r k g s z ch gh sc gl gn qu c pr br tr st sp".split(), "aeiou"),
    cs=("p b m f v t d n l r k h s z c j ch pr br st".split(), "aeiou"),
    fi=("p m v t n l r k h s j pp mm tt".split(), "aeiouy"),
    ca=("p b m f v t d n l r c g s x ny ll".split(), "aeiou"))


def invented(rng, language):
    """Words that no language has, by its spelling."""
    begins, vowels = SYLLABLES[language]
    return " ".join(
        "".join(rng.choice(begins) + rng.choice(list(vowels)) for _ in range(rng.integers(1, 4)))
        for _ in range(rng.integers(4, 9)))


def resample(x, factor):
    """By its spectrum: `factor` times as many samples."""
    n = int(round(len(x) * factor))
    spectrum = np.fft.rfft(x)
    out = np.zeros(n // 2 + 1, complex)
    m = min(len(out), len(spectrum))
    out[:m] = spectrum[:m]
    return np.fft.irfft(out, n) * (n / len(x))


def text_of(rng, language):
    if language.startswith("en") and rng.random() < 0.85:
        words = list(rng.choice(WORDS, rng.integers(4, 11)))
        if rng.random() < 0.3:
            words.insert(int(rng.integers(1, len(words))), "…,")
        return " ".join(words) + rng.choice([".", "?", "!"])
    return ", ".join(str(rng.integers(1, 10 ** int(rng.integers(1, 6)))) for _ in range(3))


def through_a_room(rng, x):
    """What lies between a mouth and a file."""
    n = len(x)
    spectrum = np.fft.rfft(x)
    f = np.arange(len(spectrum)) * RATE / n
    tilt = sum(rng.normal(0, 2.5) * np.cos(np.pi * k * f / (RATE / 2)) for k in range(1, 4))
    gain = 10 ** (tilt / 20)
    if rng.random() < 0.15:  # a telephone
        gain = gain / (1 + (250 / np.maximum(f, 1)) ** 4) / (1 + (f / 3400) ** 8)
    x = np.fft.irfft(spectrum * gain, n)
    if rng.random() < 0.3:
        tail = np.arange(int(0.3 * RATE)) / RATE
        echo = rng.normal(size=len(tail)) * np.exp(-tail * 6.9 / rng.uniform(0.08, 0.35))
        echo *= 10 ** (rng.uniform(-20, -8) / 20) / np.sqrt((echo ** 2).sum())
        echo[0] += 1
        x = np.fft.irfft(np.fft.rfft(x, n + len(tail)) * np.fft.rfft(echo, n + len(tail)))[:n]
    if rng.random() < 0.7:
        noise = np.fft.rfft(rng.normal(size=n)) / np.maximum(f, 50) ** rng.uniform(0, 1)
        noise = np.fft.irfft(noise, n)
        x = x + noise * (x.std() / noise.std() * 10 ** (-rng.uniform(8, 50) / 20))
    return x * (10 ** (rng.uniform(-42, -10) / 20) / (x.std() + 1e-6))


def heard(rng, utterances, closure):
    """[(samples, phonemes)] of one speaker, in one room -> log-mel and weights."""
    stretch = rng.uniform(0.86, 1.16)  # another throat
    samples, segments, begin = [], [], 0.0
    for x, phonemes in utterances:
        pause = rng.uniform(0.1, 0.8 if rng.random() < 0.8 else 3)
        begin += pause
        samples += [np.zeros(int(pause * RATE)), resample(x, stretch)]
        spoken = segments_of(phonemes, len(x) / RATE, closure)
        segments += [(v, b * stretch + begin, e * stretch + begin) for v, b, e in spoken]
        begin += len(samples[-1]) / RATE
    samples.append(np.zeros(int(rng.uniform(0.1, 1.5) * RATE)))
    ends = [-1] + [e for _, _, e in segments]
    begins = [b for _, b, _ in segments] + [1e3]
    segments += [("sil", e, b) for e, b in zip(ends, begins) if b > e + 0.02]
    e = log_mel(np.clip(through_a_room(rng, np.concatenate(samples)), -1, 1))
    return e, weights_of(segments, len(e)).astype(np.float32)


def language_of(speaker):
    return FESTIVAL.get(speaker, ("", "en"))[1]


def text_for(rng, speaker):
    language = language_of(speaker)
    return text_of(rng, "en") if language == "en" else invented(rng, language)


TOGETHER = 3  # utterances of a speaker in a row


def corpus(seed, spoken, recorded, speakers):
    """[(log-mel, weights)] of rows of utterances: `spoken` by espeak-ng, `recorded` of each."""
    rng = np.random.default_rng(seed)
    speaker = Speaker()
    rows = []
    for _ in range(spoken):
        language = rng.choice(LANGUAGES)
        voice = language + rng.choice(VARIANTS), int(rng.integers(15, 95)), int(
            rng.integers(110, 250))
        said = [speaker.say(text_of(rng, language), *voice) for _ in range(TOGETHER)]
        rows.append(heard(rng, said, ESPEAK_CLOSURE))
    sentences = [(name, text_for(rng, name)) for name in speakers
                 for _ in range(recorded * TOGETHER)]
    said = [(x, phonemes) for _, x, phonemes in recordings(sentences)]
    for i in range(0, len(said), TOGETHER):
        rows.append(heard(rng, said[i:i + TOGETHER], 0))
    return rows
