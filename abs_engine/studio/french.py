"""77 French sentences as phonemes, with many closures of the lips; every phoneme of French.

The text is our own. Odisio and Bailly (2003), section 5.1, track an articulatory-balanced set of 77
sentences that they do not print; theirs has 7546 frames.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from abs_engine.studio.speech import Utterance, parse_phonemes

_ALL = "p b t d k g f v s z S Z m n J N l R j w H i e E a O o u y 2 9 @ E~ A~ O~ 9~"
PHONEMES = tuple(_ALL.split())
"""Of French, in X-SAMPA; a and A are one, as with most speakers; N is that of 'parking'."""
_EDGE = 0.5  # seconds of rest before and after a sentence


@dataclass(frozen=True)
class Sentence:
    """A sentence.

    Parameters
    ----------
    name : str
        A word of it that no other name has.
    text : str
        As it is spelled.
    sounds : str
        In X-SAMPA, with spaces between words and '_' for a pause.
    """

    name: str
    text: str
    sounds: str

    @property
    def phonemes(self) -> tuple[str, ...]:
        """Its sounds one by one, X-SAMPA."""
        return tuple(re.findall(r"[^\s~]~?", self.sounds))

    @property
    def utterance(self) -> Utterance:
        """With usual durations, and rest before and after."""
        return parse_phonemes(f"_({_EDGE}) {' '.join(self.phonemes)} _({_EDGE})")


_TEXT = """
massue : Sa massue de bois pendait au mur, tout près de la porte.
  sa masy d@ bwa pA~dE o myR _ tu pRE d@ la pORt
bouquet : Papa a posé un beau bouquet blanc sur le buffet de la chambre.
  papa a poze 9~ bo bukE blA~ syR l@ byfE d@ la SA~bR
marché : Ma mère mange une pomme mûre au milieu du marché.
  ma mER mA~Z yn pOm myR o milj2 dy maRSe
facteur : Le vieux facteur a vu filer six wagons vides vers le fleuve.
  l@ vj2 fakt9R a vy file si vagO~ vid vER l@ fl9v
buisson : Julien a jeté son joli chapeau jaune dans un buisson.
  ZyljE~ a Z@te sO~ ZOli Sapo Zon dA~z 9~ bHisO~
dimanche : Chaque dimanche, Charlotte cherche des champignons sous les châtaigniers.
  Sak dimA~S _ SaRlOt SERS de SA~piJO~ su le SatEJe
brioche : Un parfum de brioche montait du fond de la boulangerie.
  9~ paRf9~ d@ bRijOS mO~tE dy fO~ d@ la bulA~ZRi
vigne : Huit nuits de pluie ont suffi à noyer la vigne du moine.
  Hit nHi d@ plHi O~ syfi a nwaje la viJ dy mwan
agneau : Le petit agneau brun se baigne dans la montagne espagnole.
  l@ p@tit aJo bR9~ s@ bEJ dA~ la mO~taJ EspaJOl
pourquoi : Pourquoi boit-il toujours trois fois de l'eau froide au bois ?
  puRkwa bwatil tuZuR tRwa fwa d@ lo fRwad o bwa
bavoir : Bébé babille et bave beaucoup sur son bavoir bleu.
  bebe babij e bav boku syR sO~ bavwaR bl2
pneus : Deux pneus neufs valent mieux que vingt vieux vélos.
  d2 pn2 n9f val mj2 k@ vE~ vj2 velo
fumée : La fumée du feu monte vers la fenêtre ouverte de la ferme.
  la fyme dy f2 mO~t vER la f@nEtR uvERt d@ la fERm
moutons : Mon oncle Edmond compte ses moutons blancs avant de dormir.
  mO~n O~kl EdmO~ kO~t se mutO~ blA~ avA~ d@ dORmiR
peintre : Le peintre a peint un pin, un lapin, et cinq poussins bruns.
  l@ pE~tR a pE~ 9~ pE~ _ 9~ lapE~ _ e sE~k pusE~ bR9~
sable : Emma aime marcher pieds nus dans le sable humide à l'aube.
  Ema Em maRSe pje ny dA~ l@ sabl ymid a lob
jument : La jument galope jusqu'au pré, puis boit à la source.
  la ZymA~ galOp Zysko pRe _ pHi bwa a la suRs
ponton : Un homme âgé fume la pipe, assis au bout du ponton.
  9~n Om aZe fym la pip _ asi o bu dy pO~tO~
salsifis : Simone sème des salsifis, des choux et des asperges.
  simOn sEm de salsifi _ de Su e dez aspERZ
goujon : Le chat gourmand guette un gros goujon gris dans le bocal.
  l@ Sa guRmA~ gEt 9~ gRo guZO~ gRi dA~ l@ bOkal
brume : Quand la brume tombe, le port paraît plus proche et plus calme.
  kA~ la bRym tO~b _ l@ pOR paRE ply pROS e ply kalm
voiture : Votre voisine a vendu sa voiture verte à un avocat.
  vOtR vwazin a vA~dy sa vwatyR vERt a 9~n avOka
abeilles : Les abeilles bourdonnent au-dessus des tilleuls et des glycines.
  lez abEj buRdOn od@sy de tij9l e de glisin
renard : Il faut beaucoup de patience pour apprivoiser un renard.
  il fo boku d@ pasjA~s puR apRivwaze 9~ R@naR
potage : Ce soir, nous mangerons du potage, du poulet et des prunes.
  s@ swaR _ nu mA~ZRO~ dy pOtaZ _ dy pulE e de pRyn
bûcheron : Le bûcheron abat un arbre mort au bord de l'étang.
  l@ bySRO~ aba 9~n aRbR mOR o bOR d@ letA~
poupée : Une poupée de porcelaine dormait dans un berceau de bois.
  yn pupe d@ pORs@lEn dORmE dA~z 9~ bERso d@ bwa
zinnias : Zoé a choisi une rose et douze zinnias chez la fleuriste.
  zoe a Swazi yn Roz e duz zinja Se la fl9Rist
pompier : Le jeune pompier grimpe vite au sommet de l'échelle.
  l@ Z9n pO~pje gRE~p vit o sOmE d@ leSEl
omelette : Mes amis bretons m'ont préparé une omelette aux champignons.
  mez ami bR@tO~ mO~ pRepaRe yn OmlEt o SA~piJO~
muguet : Un brin de muguet parfume toute la maison de ma tante.
  9~ bRE~ d@ mygE paRfym tut la mEzO~ d@ ma tA~t
bateau : Le bateau du pêcheur balance doucement contre le quai.
  l@ bato dy pES9R balA~s dusmA~ kO~tR l@ kE
pont : Philippe a perdu son vélo neuf près du pont de pierre.
  filip a pERdy sO~ velo n9f pRE dy pO~ d@ pjER
pigeons : La vieille dame nourrit les pigeons avec du pain rassis.
  la vjEj dam nuRi le piZO~ avEk dy pE~ Rasi
singes : Nous avons vu cinq singes suspendus à une branche souple.
  nuz avO~ vy sE~k sE~Z syspA~dy a yn bRA~S supl
bouillon : Ton frère a bu un bol de bouillon bien chaud.
  tO~ fRER a by 9~ bOl d@ bujO~ bjE~ So
château : Le mur du château est couvert de mousse et de lierre.
  l@ myR dy Sato E kuvER d@ mus e d@ ljER
peuples : Peu de peuples ont peur du feu et des loups.
  p2 d@ p9pl O~ p9R dy f2 e de lu
mouche : Une mouche bleue bourdonne contre la vitre embuée.
  yn muS bl2 buRdOn kO~tR la vitR A~bHe
juge : Jeudi, le juge a jugé Georges et son jeune complice.
  Z2di _ l@ ZyZ a ZyZe ZORZ e sO~ Z9n kO~plis
parking : Le parking du magasin ferme à minuit et demi.
  l@ paRkiN dy magazE~ fERm a minHi e d@mi
chanson : Sophie chuchote une chanson douce à sa fille fiévreuse.
  sOfi SySOt yn SA~sO~ dus a sa fij fjevR2z
bourgeons : Au printemps, les bourgeons poussent au bout des branches.
  o pRE~tA~ _ le buRZO~ pus o bu de bRA~S
banquise : Un aviateur survole la banquise à bord de son ballon.
  9~n avjat9R syRvOl la bA~kiz a bOR d@ sO~ balO~
brochet : Hugo pêche un brochet, une perche et quelques ablettes.
  ygo pES 9~ bROSE _ yn pERS e kElk@z ablEt
billes : Les enfants jouent aux billes pendant que leur mère bavarde.
  lez A~fA~ Zu o bij pA~dA~ k@ l9R mER bavaRd
neige : La neige fond déjà sur les bords du chemin boueux.
  la nEZ fO~ deZa syR le bOR dy S@mE~ bu2
piano : Mon parrain m'apprend à jouer du piano et du violon.
  mO~ paRE~ mapRA~ a Zwe dy pjano e dy vjOlO~
menuisier : Le menuisier rabote une planche épaisse de chêne massif.
  l@ m@nHizje RabOt yn plA~S epEs d@ SEn masif
montre : Ma montre en or marque midi moins cinq, et le train part.
  ma mO~tR A~n OR maRk midi mwE~ sE~k _ e l@ tRE~ paR
falaises : Le vent du nord souffle fort sur les falaises blanches.
  l@ vA~ dy nOR sufl fOR syR le falEz blA~S
cabane : Bruno a bâti une cabane en bambou au fond du jardin.
  bRyno a bati yn kaban A~ bA~bu o fO~ dy ZaRdE~
pansement : L'infirmière pose un pansement propre sur la plaie.
  lE~fiRmjER poz 9~ pA~smA~ pROpR syR la plE
lundi : Un lundi de juin, un parfum commun embauma le jardin.
  9~ l9~di d@ ZHE~ _ 9~ paRf9~ kOm9~ A~boma l@ ZaRdE~
confiture : Veux-tu un peu de beurre et de la confiture de mûres ?
  v2 ty 9~ p2 d@ b9R e d@ la kO~fityR d@ myR
moulin : Le moulin à vent tourne au sommet de la colline.
  l@ mulE~ a vA~ tuRn o sOmE d@ la kOlin
bruit : Trop de bruit empêche ma sœur de bien dormir la nuit.
  tRo d@ bRHi A~pES ma s9R d@ bjE~ dORmiR la nHi
guide : Le guide grimpa la pente abrupte avec son bâton ferré.
  l@ gid gRE~pa la pA~t abRypt avEk sO~ batO~ fERe
lampe : Pose la lampe au milieu de la table basse, s'il te plaît.
  poz la lA~p o milj2 d@ la tabl bas _ sil t@ plE
plage : Une grande ombre passe lentement sur la plage déserte.
  yn gRA~d O~bR pas lA~tmA~ syR la plaZ dezERt
bague : Le bijoutier fabrique une bague pour la future mariée.
  l@ biZutje fabRik yn bag puR la fytyR maRje
canard : Dans la mare, un canard plonge et remonte avec un poisson.
  dA~ la maR _ 9~ kanaR plO~Z e R@mO~t avEk 9~ pwasO~
boucher : Le boucher emballe deux beaux morceaux de bœuf maigre.
  l@ buSe A~bal d2 bo mORso d@ b9f mEgR
boutique : Ma cousine habite au-dessus d'une boutique de chapeaux.
  ma kuzin abit od@sy dyn butik d@ Sapo
soleil : Le soleil couchant baigne la vallée d'une lumière pourpre.
  l@ sOlEj kuSA~ bEJ la vale dyn lymjER puRpR
hangar : On entend la pluie tambouriner sur le toit du hangar.
  O~n A~tA~ la plHi tA~buRine syR l@ twa dy A~gaR
fromage : Le fromage de brebis sent bon le thym et la bruyère.
  l@ fROmaZ d@ bR@bi sA~ bO~ l@ tE~ e la bRHijER
gâteau : Chouette, un gâteau aux amandes pour mon anniversaire !
  SwEt _ 9~ gato oz amA~d puR mO~n anivERsER
valise : Le voyageur ferme sa valise et quitte la gare à l'heure.
  l@ vwajaZ9R fERm sa valiz e kit la gaR a l9R
platanes : Jean et Bernard jouent aux boules sous les platanes.
  ZA~ e bERnaR Zu o bul su le platan
poule : La poule rousse pond un œuf brun chaque matin.
  la pul Rus pO~ 9~n 9f bR9~ Sak matE~
gendarme : Un gendarme aimable montre le chemin du musée aux passants.
  9~ ZA~daRm Emabl mO~tR l@ S@mE~ dy myze o pasA~
rivière : Il neige beaucoup, mais la rivière ne gèle jamais.
  il nEZ boku _ mE la RivjER n@ ZEl ZamE
ruche : L'ours brun fouille la ruche pour un peu de miel.
  luRs bR9~ fuj la RyS puR 9~ p2 d@ mjEl
tambour : Le tambour bat, la foule applaudit, puis le bal commence.
  l@ tA~buR ba _ la ful aplodi _ pHi l@ bal kOmA~s
manteau : Mets ton manteau, ton bonnet et tes bottes fourrées.
  mE tO~ mA~to _ tO~ bOnE e te bOt fuRe
demain : Bonne nuit, et à demain pour une nouvelle promenade.
  bOn nHi _ e a d@mE~ puR yn nuvEl pROm@nad
"""


def _read(text: str) -> tuple[Sentence, ...]:
    lines = text.strip().splitlines()
    heads = [line.split(" : ", 1) for line in lines[::2]]
    return tuple(
        Sentence(name, said, sounds.strip())
        for (name, said), sounds in zip(heads, lines[1::2], strict=True)
    )


SENTENCES = _read(_TEXT)
"""All 77; the first has the word that the paper's figure 8 shows."""
QUICK = SENTENCES[:2]
"""For a quick look."""
PRACTICE = Sentence(
    "berger",
    "La massue du berger pesait plus lourd que son panier de pommes.",
    "la masy dy bERZe p@zE ply luR k@ sO~ panje d@ pOm",
)
"""None of the 77: settings are chosen on it."""
