// German for several operators: who has control authority over which vehicles, and who asks for them.

export const operators = {
  // settings
  'Your name, as other operators see it': 'Ihr Name, wie andere Bediener ihn sehen', 'as {name}': 'als {name}', 'Change your name in the settings': 'Ihren Namen in den Einstellungen ändern',
  // whose a vehicle is
  'Controlled by': 'Gesteuert von', 'Whose commands it takes': 'Wessen Befehle es annimmt', you: 'Sie', asked: 'angefragt', 'under the control of {name}': 'unter der Kontrolle von {name}', 'by operator': 'nach Bediener',
  "Under nobody's control": 'Unter niemandes Kontrolle', 'Under the control of {name}': 'Unter der Kontrolle von {name}', 'Under your control': 'Unter Ihrer Kontrolle',
  "under another operator's control": 'unter der Kontrolle eines anderen Bedieners', 'the same, and not heard': 'ebenso, und nicht gehört',
  // the targets
  'Who has control authority over the targets': 'Wer die Steuerhoheit über die Ziele hat', '{count} yours': '{count} bei Ihnen', '{count} with {name}': '{count} bei {name}', '{count} with others': '{count} bei anderen', "{count} nobody's": '{count} bei niemandem',
  Take: 'Übernehmen', 'Take {count}': '{count} übernehmen', 'Ask for {count}': 'Um {count} bitten', 'asked for {count}': 'um {count} gebeten', 'Let go {count}': '{count} freigeben', 'Target your {count}': 'Ihre {count} zu Zielen machen',
  'Only you command them then; hold, land, return and stop stay with everybody': 'Dann befehlen nur Sie ihnen; halten, landen, zurück und Nothalt bleiben allen',
  'Who has them is told that you ask': 'Wer sie hat, erfährt, dass Sie bitten', 'They go to who asked first, else to nobody': 'Sie gehen an den, der zuerst bat, sonst an niemanden',
  'Take, ask for or let go the targets': 'Ziele übernehmen, um sie bitten oder sie freigeben', 'Answer who asks for vehicles': 'Wer um Fahrzeuge bittet: antworten',
  // requests
  'Requests for vehicles': 'Bitten um Fahrzeuge', '{name} asks for {who}': '{name} bittet um {who}', 'Hand over': 'Übergeben', 'Not now': 'Jetzt nicht', 'and {count} more who ask': 'und {count} weitere, die bitten',
  // after a restart of the node
  'After the restart': 'Nach dem Neustart', 'not flown on: {why}': 'nicht weitergeflogen: {why}', 'Fly on': 'Weiterfliegen', 'Do not fly on': 'Nicht weiterfliegen', 'Not taken back: {who}': 'Nicht zurückgeholt: {who}',
  'The node ended in flight and has started again. {who} hold; the formation is not flown on yet.': 'Der Knoten ist im Flug ausgefallen und neu gestartet. {who} halten; die Formation fliegt noch nicht weiter.',
  'The node ended in flight and has started again. {who} hold; what they did is not flown on yet.': 'Der Knoten ist im Flug ausgefallen und neu gestartet. {who} halten; was sie taten, geht noch nicht weiter.',
  // what came of it
  'Control taken: {who}': 'Übernommen: {who}', 'Control not taken': 'Nicht übernommen', 'Asked for: {who}': 'Gebeten um: {who}', 'Not asked for': 'Nicht gebeten um', 'Let go: {who}': 'Freigegeben: {who}', 'Not let go': 'Nicht freigegeben',
  'Handed over to {name}: {who}': 'An {name} übergeben: {who}', 'Not handed over': 'Nicht übergeben', '{name} has taken over: {who}': '{name} hat übernommen: {who}', 'Under your control now: {who}': 'Jetzt in Ihrer Hand: {who}',
  'vehicle {vehicle} is under the control of {holder}': 'Fahrzeug {vehicle} ist unter der Kontrolle von {holder}',
} as const;
