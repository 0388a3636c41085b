// German for the parameters of autopilots.

export const parameters = {
  Parameters: 'Parameter', 'Parameters of vehicle {id}': 'Parameter von Fahrzeug {id}', 'Back to vehicle {id}': 'Zurück zu Fahrzeug {id}', 'Reading the parameters': 'Parameter werden gelesen',
  'Read the rest': 'Rest lesen', 'Read again': 'Neu lesen', 'Read all': 'Alle lesen', 'This vehicle is flown over DDS, and its parameters cannot be reached there. They can over MAVLink.': 'Dieses Fahrzeug wird über DDS geflogen; dort sind seine Parameter nicht erreichbar. Über MAVLink sind sie es.',
  'Find parameters by name': 'Parameter nach Namen finden', 'Changed here ({count})': 'Hier geändert ({count})', 'By prefix': 'Nach Vorsilbe', 'The vehicle is armed: nothing can be written.': 'Das Fahrzeug ist scharf: nichts kann geschrieben werden.',
  'The first ones are awaited.': 'Die ersten werden erwartet.', 'None is known yet.': 'Noch keiner ist bekannt.', 'No parameter fits.': 'Kein Parameter passt.',
  'List of parameters': 'Liste der Parameter', Name: 'Name', Value: 'Wert', Type: 'Typ', Change: 'Ändern', 'Change {name}': '{name} ändern', 'was {value}': 'war {value}', 'now {value}': 'jetzt {value}',
  whole: 'ganz', real: 'reell', 'As before: {value}': 'Wie vorher: {value}', Writing: 'Schreibt', 'Write {name} of {id}': '{name} von {id} schreiben', 'Something else is selected than {id}.': 'Etwas anderes als {id} ist ausgewählt.', Close: 'Schließen',
  '{name} is {value} now, was {before}': '{name} ist jetzt {value}, war {before}', '{name} is {value} now': '{name} ist jetzt {value}', 'Not written: {why}': 'Nicht geschrieben: {why}',
  'Type a value.': 'Einen Wert eingeben.', 'That is no number.': 'Das ist keine Zahl.', 'This parameter takes whole numbers.': 'Dieser Parameter nimmt ganze Zahlen.', 'That is more than 32 bits hold.': 'Das ist mehr, als 32 Bit fassen.',
  'Not read yet.': 'Noch nicht gelesen.', 'Asking the autopilot': 'Autopilot wird gefragt', 'Reading, {read} of {total}': 'Liest, {read} von {total}', 'All {total} read': 'Alle {total} gelesen', 'Read {read} of {total}: {why}': '{read} von {total} gelesen: {why}',
  '{name} is not written while the vehicle is armed: disarm it first': '{name} wird nicht geschrieben, solange das Fahrzeug scharf ist: erst entschärfen', 'the autopilot has no parameter {name}': 'der Autopilot hat keinen Parameter {name}',
  'no answer about {name}; the autopilot may not have it': 'keine Antwort zu {name}; vielleicht hat ihn der Autopilot nicht', '{name} is {type}: {value} does not fit': '{name} ist {type}: {value} passt nicht', '{value} is out of the range of {name}': '{value} liegt nicht im Bereich von {name}',
  'the autopilot keeps {name} at {kept} instead of {asked}': 'der Autopilot behält {name} bei {kept} statt {asked}', 'too many writes are waiting already': 'zu viele Schreibvorgänge warten schon', 'broken off: {why}': 'abgebrochen: {why}',
} as const;
