// German for flying by hand.

export const hand = {
  'By hand': 'Von Hand', 'Fly by hand': 'Von Hand fliegen', 'Fly {name} by hand': '{name} von Hand fliegen',
  'End: {name} holds': 'Beenden: {name} hält', 'End: {name} stands and leads': 'Beenden: {name} steht und führt',
  'Select one vehicle first: one alone is flown by hand.': 'Erst ein Fahrzeug auswählen: von Hand geflogen wird eines allein.', 'Select the leader, {leader}': 'Den Führer auswählen, {leader}',
  'No connection: nothing is sent.': 'Keine Verbindung: es wird nichts gesendet.', 'Somebody else has it: {name}': 'Jemand anders hat es: {name}', 'It is on the ground: let it take off first.': 'Es ist am Boden: lassen Sie es erst starten.',
  'Not flown by hand.': 'Nicht von Hand geflogen.', 'Not flown by hand any more: {why}': 'Nicht mehr von Hand geflogen: {why}', '{who} is told that it is to be flown by hand': '{who} wird gesagt, dass es von Hand geflogen wird',
  'This page is not looked at: nothing is sent, {who} stands': 'Diese Seite ist nicht im Blick: es wird nichts gesendet, {who} steht', 'Link lost: nothing is sent, {who} stands': 'Verbindung verloren: es wird nichts gesendet, {who} steht',
  'Let the dead-man go, then hold it again: {who} stands': 'Totmann loslassen und wieder halten: {who} steht', 'Let go: {who} stands': 'Losgelassen: {who} steht', 'Steering {who}': '{who} wird gesteuert',
  'Refused for now: {why}': 'Vorerst abgelehnt: {why}', 'it is not flown by hand any more': 'es wird nicht mehr von Hand geflogen', 'nobody has held the sticks for ten seconds': 'zehn Sekunden lang hat niemand gesteuert',
  'Gamepad: {name}. RB or R1 is the dead-man.': 'Gamepad: {name}. RB oder R1 ist der Totmann.', 'This browser does not know the layout of {name}: it is not used.': 'Dieser Browser kennt die Belegung von {name} nicht: es wird nicht benutzt.',
  'This browser gives this page no gamepads: it wants HTTPS, or the page on this computer.': 'Dieser Browser gibt dieser Seite keine Gamepads: er verlangt HTTPS oder die Seite auf diesem Rechner.',
  'No gamepad. One that is connected is seen when a button on it is pressed.': 'Kein Gamepad. Ein angeschlossenes wird erkannt, sobald eine Taste daran gedrückt wird.',
  'Left stick': 'Linker Knüppel', 'Right stick': 'Rechter Knüppel', climb: 'steigen', turn: 'drehen', forward: 'vorwärts', sideways: 'seitwärts', 'Hold to steer': 'Zum Steuern halten', Held: 'Gehalten',
  'It flies only while this or RB is held, and stands otherwise. By keyboard: hold Space on the button, then W A S D and the arrows.': 'Es fliegt nur, solange dies oder RB gehalten wird, und steht sonst. Mit der Tastatur: Leertaste auf dem Knopf halten, dazu W A S D und die Pfeile.',
  Fastest: 'Höchstens', slow: 'langsam', medium: 'mittel', fast: 'schnell', '{level}, up and down {climb}': '{level}, auf und ab {climb}',
} as const;
