// German for live video.

export const video = {
  // the page
  Video: 'Video', Wall: 'Wand', 'One large': 'Eines groß', 'Beside the map': 'Neben der Karte', 'How the streams are shown': 'Wie die Videos gezeigt werden', 'All streams': 'Alle Videos',
  '{live} of {count} live': '{live} von {count} aktuell', 'No payload gives video.': 'Keine Nutzlast liefert Video.', Way: 'Übertragung', automatic: 'automatisch', 'needs HTTPS': 'braucht HTTPS', 'not in this browser': 'nicht in diesem Browser',
  'Recordings on the node': 'Aufnahmen auf dem Knoten', '{count}, {running} under way': '{count}, davon {running} laufend', 'under way': 'läuft noch',
  // one stream
  'waiting for the first picture': 'wartet auf das erste Bild', Age: 'Alter', Rate: 'Rate', Size: 'Größe', 'Glass to glass': 'Glas zu Glas', 'Glass to glass p50, p99': 'Glas zu Glas p50, p99',
  'measured only where the camera draws a clock into its pictures': 'nur gemessen, wo die Kamera eine Uhr in ihre Bilder zeichnet',
  'from the camera to this screen, last ten seconds: half of the pictures within {p50}, all but one in a hundred within {p99}': 'von der Kamera bis auf diesen Bildschirm, letzte zehn Sekunden: die Hälfte der Bilder in {p50}, alle bis auf eines von hundert in {p99}',
  '{way} failed: {why}': '{way} ging nicht: {why}', 'no picture came': 'kein Bild kam', 'this browser does not have this way': 'dieser Browser kann diese Übertragung nicht',
  'WebRTC found no way to the node': 'WebRTC fand keinen Weg zum Knoten', 'the server does not give the stream': 'der Server gibt das Video nicht her', 'the server has gone silent': 'der Server schweigt',
  // what is done with it
  'Show large': 'Groß zeigen', 'Picture in picture on the map': 'Als kleines Bild auf der Karte', 'Picture in picture: {vehicle} {payload}': 'Kleines Bild: {vehicle} {payload}', 'Put it into the next corner': 'In die nächste Ecke setzen', 'Close the picture': 'Bild schließen',
  Still: 'Standbild', 'Save this picture as a file': 'Dieses Bild als Datei speichern', 'Record video': 'Video aufnehmen', 'Records on the node, whoever looks': 'Nimmt auf dem Knoten auf, wer auch zusieht', 'Stop, {time}': 'Ende, {time}',
  'not recorded: {why}': 'nicht aufgenommen: {why}', 'recording not ended: {why}': 'Aufnahme nicht beendet: {why}',
} as const;
