// The words of the page's controls in the language of who reads them: English, German, French or Spanish. What is not in the table stays
// English, as do numbers, messages and the laboratory.

export const kLanguages = ['en', 'de', 'fr', 'es'] as const;
export type Language = (typeof kLanguages)[number];

// No longer than the English ones by much: the smallest screens have no room.
const kTable: Record<string, readonly [de: string, fr: string, es: string]> = {
  'Measure': ['Messen', 'Mesure', 'Medir'],
  'Cut': ['Schnitt', 'Coupe', 'Corte'],
  'Across the view': ['Quer zum Blick', 'En travers de la vue', 'A trav\u00e9s de la vista'],
  'Other side': ['Andere Seite', 'Autre c\u00f4t\u00e9', 'Otro lado'],
  'Close': ['Schlie\u00dfen', 'Fermer', 'Cerrar'],
  'Or measure a line or an area, and cut along it.': ['Oder eine Linie oder Fl\u00e4che messen und daran entlang schneiden.', 'Ou mesurer une ligne ou une surface, et couper le long.', 'O medir una l\u00ednea o un \u00e1rea, y cortar por ella.'],
  'Path': ['Weg', 'Trajet', 'Ruta'],
  'Record': ['Film', 'Film', 'Grabar'],
  'Share': ['Teilen', 'Lien', 'Enlace'],
  'Survey': ['Umflug', 'Survol', 'Vuelo'],
  'Canyon': ['Tal', 'Vall\u00e9e', 'Ca\u00f1\u00f3n'],
  'Spin': ['Drehen', 'Tour', 'Giro'],
  'Orbit': ['Kreis', 'Orbite', '\u00d3rbita'],
  'Settings': ['Ansicht', 'R\u00e9glages', 'Ajustes'],
  'Ground': ['Boden', 'Sol', 'Suelo'],
  'Natural': ['Nat\u00fcrlich', 'Naturel', 'Natural'],
  'Plain': ['Einfarbig', 'Uni', 'Liso'],
  'Slope': ['Neigung', 'Pente', 'Pendiente'],
  'Aspect': ['Ausrichtung', 'Orientation', 'Orientaci\u00f3n'],
  'Heights': ['H\u00f6hen', 'Altitudes', 'Alturas'],
  'Change in time': ['Wandel', '\u00c9volution', 'Cambio'],
  'Colours': ['Farben', 'Couleurs', 'Colores'],
  'Open a .cpt file': ['.cpt \u00f6ffnen', 'Ouvrir un .cpt', 'Abrir un .cpt'],
  'Snow line': ['Schneegrenze', 'Limite de neige', 'L\u00ednea de nieve'],
  'Sun': ['Sonne', 'Soleil', 'Sol'],
  'As on maps': ['Wie auf Karten', 'Comme sur cartes', 'Como en mapas'],
  'Date and time': ['Datum und Uhr', 'Date et heure', 'Fecha y hora'],
  'Free': ['Frei', 'Libre', 'Libre'],
  'Day': ['Tag', 'Jour', 'D\u00eda'],
  'Hour': ['Stunde', 'Heure', 'Hora'],
  'Azimuth': ['Azimut', 'Azimut', 'Acimut'],
  'Height': ['H\u00f6he', 'Hauteur', 'Altura'],
  'Imagery': ['Luftbild', 'Imagerie', 'Im\u00e1genes'],
  'Relief shading': ['Relief', 'Relief', 'Relieve'],
  'Cast shadows': ['Schatten', 'Ombres', 'Sombras'],
  'Contours': ['H\u00f6henlinien', 'Courbes', 'Curvas'],
  'Haze': ['Dunst', 'Brume', 'Bruma'],
  'Sea': ['Meer', 'Mer', 'Mar'],
  'Names': ['Namen', 'Noms', 'Nombres'],
  'Map': ['Karte', 'Carte', 'Mapa'],
  'Lay on the ground': ['Auf den Boden', 'Poser au sol', 'Poner al suelo'],
  'Speed': ['Tempo', 'Vitesse', 'Velocidad'],
  'Quality': ['G\u00fcte', 'Qualit\u00e9', 'Calidad'],
  'Finest': ['Feinste', 'La plus fine', 'La m\u00e1s fina'],
  'Fine': ['Fein', 'Fine', 'Fina'],
  'Good': ['Gut', 'Bonne', 'Buena'],
  'Fast': ['Schnell', 'Rapide', 'R\u00e1pida'],
  'Fastest': ['Schnellste', 'La plus rapide', 'La m\u00e1s r\u00e1pida'],
  'Laboratory': ['Labor', 'Laboratoire', 'Laboratorio'],
  'Clear': ['Leeren', 'Effacer', 'Borrar'],
  'Add': ['Dazu', 'Ajouter', 'A\u00f1adir'],
  'Fly': ['Fliegen', 'Voler', 'Volar'],
  'Cancel': ['Abbrechen', 'Annuler', 'Cancelar'],
  'Picture': ['Bild', 'Image', 'Imagen'],
  'Video': ['Video', 'Vid\u00e9o', 'V\u00eddeo'],
  'Frames a second': ['Bilder je Sekunde', 'Images par seconde', 'Im\u00e1genes por s'],
  'Format': ['Format', 'Format', 'Formato'],
  'Seconds': ['Sekunden', 'Secondes', 'Segundos'],
  'Save a picture': ['Bild speichern', 'Enregistrer l\u2019image', 'Guardar imagen'],
  'Record the flight': ['Flug aufnehmen', 'Filmer le vol', 'Grabar el vuelo'],
  'Copy the link': ['Link kopieren', 'Copier le lien', 'Copiar el enlace'],
  'Copy the frame': ['Rahmen kopieren', 'Copier le cadre', 'Copiar el marco'],
  'Frame': ['Rahmen', 'Cadre', 'Marco'],
  'Drag to look around': ['Ziehen: umsehen', 'Glisser : regarder autour', 'Arrastrar: mirar alrededor'],
  'W A S D or the arrows fly, E and Q rise and sink': ['W A S D oder Pfeile: fliegen, E und Q: steigen und sinken', 'Z Q S D (touches W A S D) ou fl\u00e8ches : voler, E et A : monter et descendre', 'W A S D o flechas: volar, E y Q: subir y bajar'],
  'The wheel sets the speed, shift-click and V show what is seen': ['Rad: Tempo, Umschalt-Klick und V: was man sieht', 'Molette : vitesse, Maj-clic et V : ce qui se voit', 'Rueda: velocidad, May\u00fas-clic y V: lo que se ve'],
  'One finger looks around': ['Ein Finger: umsehen', 'Un doigt : regarder autour', 'Un dedo: mirar alrededor'],
  'Pinch to near the ground, twist to turn': ['Spreizen: dem Boden n\u00e4hern, drehen: wenden', '\u00c9carter : approcher du sol, tourner : pivoter', 'Separar: acercarse al suelo, girar: rotar'],
  'Latitude, longitude': ['Breite, L\u00e4nge', 'Latitude, longitude', 'Latitud, longitud'],
  'Drag the ground, the wheel nears what you point at': ['Boden ziehen, das Rad n\u00e4hert sich dem Gezeigten', 'Tirez le sol, la molette approche ce que vous pointez', 'Arrastra el suelo, la rueda acerca lo que se\u00f1alas'],
  'The right button tilts, beside the ground you look around': ['Rechte Taste: neigen, neben dem Boden: umsehen', 'Bouton droit : incliner, hors du sol : regarder autour', 'Bot\u00f3n derecho: inclinar, fuera del suelo: mirar'],
  'One finger drags the ground': ['Ein Finger zieht den Boden', 'Un doigt tire le sol', 'Un dedo arrastra el suelo'],
  'Pinch to near it, twist to turn': ['Spreizen: n\u00e4hern, drehen: wenden', '\u00c9carter : approcher, tourner : pivoter', 'Separar: acercar, girar: rotar'],
  'Two fingers up or down tilt': ['Zwei Finger auf und ab: neigen', 'Deux doigts de haut en bas : incliner', 'Dos dedos arriba o abajo: inclinar'],
  'Two fingers up or down tilt, three carry you': ['Zwei Finger auf und ab: neigen, drei: gleiten', 'Deux doigts de haut en bas : incliner, trois : glisser', 'Dos dedos arriba o abajo: inclinar, tres: deslizarse'],
};

// `lang=` of the address, else the first of the reader's languages that there is.
export function languageOf(asked: string | null, languages: readonly string[]): Language {
  const found = [asked ?? '', ...languages].map((tag) => tag.slice(0, 2).toLowerCase()).find((tag) => kLanguages.includes(tag as Language));
  return (found as Language | undefined) ?? 'en';
}
export function translated(text: string, language: Language): string {
  const at = kLanguages.indexOf(language) - 1;
  return at < 0 ? text : kTable[text]?.[at] ?? text;
}

let language: Language = 'en'; // the page's
export function setLanguage(chosen: Language): void {
  language = document.documentElement.lang = chosen;
}
// In the page's language.
export const said = (text: string): string => translated(text, language);
// For tests.
export const kWords = Object.keys(kTable);
