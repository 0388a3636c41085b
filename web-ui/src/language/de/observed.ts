// German for what the swarm sees and tracks.

export const observed = {
  // the list, and what is known of one
  'Nothing is tracked now.': 'Zurzeit ist nichts gefunden.', 'class not known': 'Art nicht bekannt', pinned: 'angeheftet', 'seen {age} ago': 'vor {age} gesehen', '{count} more on the map': '{count} weitere auf der Karte',
  'Track {track} has ended.': 'Fund {track} ist beendet.', 'Select a track here or on the map.': 'Hier oder auf der Karte einen Fund auswählen.',
  Class: 'Art', 'Known to': 'Genauigkeit', Confidence: 'Gewissheit', Velocity: 'Tempo', 'Seen by': 'Gesehen von', Source: 'Quelle', 'nobody says': 'niemand sagt es', 'nobody now': 'zurzeit niemand', '{age}, last seen {seen} ago': '{age}, zuletzt vor {seen} gesehen',
  'fused from what is seen': 'zusammengeführt aus dem, was gesehen wird', 'told over the API': 'über die API gemeldet', 'height {height}': 'Höhe {height}', '{speed} to {bearing}': '{speed} nach {bearing}',
  'climbs {rate}': 'steigt {rate}', 'descends {rate}': 'sinkt {rate}', '± {ground}, height ± {height}': '± {ground}, Höhe ± {height}', 'range only guessed from its size': 'Entfernung nur aus der Größe geschätzt',
  // what is done with it
  'Name of the track': 'Name des Fundes', 'Set name': 'Benennen', Pin: 'Anheften', Unpin: 'Lösen', 'Kept for longer when nobody sees it': 'Bleibt länger, wenn niemand ihn sieht', Drop: 'Verwerfen',
  'Ends the track; what its sensors see under their present names begins no new one': 'Beendet den Fund; was seine Sensoren unter ihren jetzigen Namen sehen, beginnt keinen neuen',
  'Whoever tells of this track names and ends it.': 'Wer diesen Fund meldet, benennt und beendet ihn.',
  // who observes it
  Observers: 'Beobachter', Observe: 'Beobachten', 'No vehicle has a model that observes.': 'Kein Fahrzeug hat ein Modell, das beobachtet.', 'cannot be asked': 'nicht verfügbar', 'place not known': 'Ort nicht bekannt', '{distance} away': '{distance} entfernt',
  'charge not known': 'Ladung nicht bekannt', '{share} charge': '{share} Ladung', 'camera on a gimbal': 'Kamera am Kardan', 'no camera on a gimbal': 'keine Kamera am Kardan', 'not busy': 'nicht beschäftigt', 'How many observe': 'Wie viele beobachten', 'One less': 'Eines weniger',
  'One more': 'Eines mehr', 'They fly around it and keep it in view, from sides that are spread': 'Sie fliegen um den Fund und behalten ihn von verteilten Seiten im Blick', 'looks from {bearing}': 'blickt aus {bearing}',
  // over the video
  Findings: 'Erkanntes', 'What detectors find, drawn over the video': 'Was Detektoren erkennen, über das Video gezeichnet',
} as const;
