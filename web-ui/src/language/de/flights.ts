// German for recorded flights: their list, and looking at one again.

export const flights = {
  // the list
  Flights: 'Flüge', 'Recorded flights': 'Aufgezeichnete Flüge', Begun: 'Begonnen', Duration: 'Dauer', Kind: 'Art', 'What to do with it': 'Was man damit tun kann', flown: 'geflogen', stood: 'gestanden',
  'is being written': 'wird gerade geschrieben', 'cut off': 'abgeschnitten', Report: 'Bericht', Replay: 'Wiedergabe', Download: 'Herunterladen', 'Report of {when}': 'Bericht vom {when}', 'Replay of {when}': 'Wiedergabe vom {when}', 'Download {file}': '{file} herunterladen',
  "There is no recording, and flights are not recorded: the section [recorder] of the node's configuration says whether and where.":
    'Es gibt keine Aufzeichnung, und Flüge werden nicht aufgezeichnet: der Abschnitt [recorder] in der Konfiguration des Knotens sagt, ob und wohin.',
  'There is no recording yet. Each flight becomes one: it begins before a vehicle is armed and ends after all have landed.':
    'Es gibt noch keine Aufzeichnung. Jeder Flug wird eine: sie beginnt, bevor ein Fahrzeug geschärft wird, und endet, nachdem alle gelandet sind.',
  'Reports and replays open beside this page. The files are MCAP, which Foxglove and Lichtblick open as well.': 'Berichte und Wiedergaben öffnen sich neben dieser Seite. Die Dateien sind MCAP, das auch Foxglove und Lichtblick öffnen.',
  // the recorder
  REC: 'AUFN', 'NOT RECORDED': 'KEINE AUFZEICHNUNG', 'Flights are not recorded: {why}': 'Flüge werden nicht aufgezeichnet: {why}', 'This flight is recorded: {file}': 'Dieser Flug wird aufgezeichnet: {file}',
  'Flights are recorded; nobody flies': 'Flüge werden aufgezeichnet; niemand fliegt', 'Flight recorded': 'Flug aufgezeichnet',
  // one that is shown again
  REPLAY: 'WIEDERGABE', 'recorded flight, not live': 'aufgezeichneter Flug, nicht live', 'A recorded flight: nothing of this happens now': 'Ein aufgezeichneter Flug: nichts davon geschieht jetzt',
  'What is shown of the recording stands still until it is back.': 'Was von der Aufzeichnung zu sehen ist, steht still, bis sie wieder da ist.',
  'Replay controls': 'Bedienung der Wiedergabe', Play: 'Weiter', Pause: 'Anhalten', 'Go on or stand still (Space)': 'Weitergehen oder stillstehen (Leertaste)', 'Mark before': 'Marke davor', 'Mark before (B)': 'Marke davor (B)', 'Next mark': 'Nächste Marke', 'Next mark (N)': 'Nächste Marke (N)',
  '10 s back (,)': '10 s zurück (,)', '10 s on (.)': '10 s weiter (.)', 'Speed of the replay': 'Tempo der Wiedergabe',
  'Time in the recording': 'Zeit in der Aufzeichnung', '{position} of {duration}, {time}': '{position} von {duration}, {time}', 'What happened': 'Was geschah', 'What operators and programs did': 'Was Bediener und Programme taten',
  '{count} from {first}': '{count} ab {first}', 'looking for what happened …': 'sucht, was geschah …', '{count} more are not shown': '{count} weitere sind nicht gezeigt', 'the replay did not obey: {why}': 'die Wiedergabe gehorchte nicht: {why}',
  'At this moment of the recording no vehicle was known.': 'In diesem Augenblick der Aufzeichnung war noch kein Fahrzeug bekannt.', 'No alert was open at this moment.': 'In diesem Augenblick war kein Alarm offen.', 'Open alerts': 'Offene Alarme',
  // keys
  'Go on or stand still': 'Weitergehen oder stillstehen', '10 s back': '10 s zurück', '10 s on': '10 s weiter', 'To the mark before': 'Zur Marke davor', 'To the next mark': 'Zur nächsten Marke',
} as const;
