// German for what is wrong with a vehicle and what is done about it.

export const words = {
  faulted: 'gestört', 'link lost': 'Verbindung verloren', 'data stale': 'Daten veraltet', 'battery critical': 'Akku kritisch', 'battery low': 'Akku schwach', 'control given up': 'Steuerung aufgegeben',
  'control restarting': 'Steuerung startet neu', degraded: 'eingeschränkt', 'pilot in control': 'Pilot steuert', 'no position': 'keine Position', 'no 3D fix': 'kein 3D-Fix', 'link loss {percent} %': '{percent} % Verlust',
  'out of its slot': 'nicht auf seinem Platz', 'data delayed': 'Daten verzögert', returning: 'kehrt zurück', landing: 'landet', 'out of reach': 'außer Reichweite',
  'warning only': 'nur Warnung', hold: 'halten', return: 'zurückkehren', land: 'landen', 'release to the autopilot': 'Übergabe an den Autopiloten', 'not known': 'unbekannt', limit: 'Grenze', 'for {time}': 'seit {time}',
  ', cause is over': ', Ursache vorbei', ', not taken up yet': ', noch nicht befolgt', 'Ordered: {reaction} because of {trigger}, for {time}': 'Angeordnet: {reaction} wegen {trigger}, seit {time}',
  'Kept inside of the fence': 'Innerhalb des Zauns gehalten', 'Gives way to {who}': 'Weicht {who} aus', ', {distance} away': ', {distance} entfernt', '; the distance cannot be kept': '; der Abstand ist nicht zu halten',
  'land now': 'jetzt landen', now: 'jetzt', 'motors stopped': 'Motoren aus', 'gives way': 'weicht aus', 'distance cannot be kept': 'Abstand nicht zu halten', '{trigger}: {reaction} ordered': '{trigger}: {reaction} angeordnet',
  'return soon for energy': 'bald zurück wegen Energie', 'return now for energy': 'jetzt zurück wegen Energie', 'land now for energy': 'jetzt landen wegen Energie',
  // why a command was refused
  'there is no vehicle {vehicle}': 'es gibt kein Fahrzeug {vehicle}', 'the link to vehicle {vehicle} is lost': 'die Verbindung zu Fahrzeug {vehicle} ist verloren', 'cannot {command} while {state}': 'nicht möglich: {command}, während es {state}',
  "the pilot or the autopilot's failsafe is in control": 'der Pilot oder die Notfunktion des Autopiloten steuert', autopilot: 'Autopilot', 'no answer to {what} within {seconds} s': 'keine Antwort auf {what} binnen {seconds} s',
  'replaced by a newer command': 'durch einen neueren Befehl ersetzt', 'outside the fence': 'außerhalb des Zauns', '{speed} is over the limit of {limit}': '{speed} liegt über der Grenze von {limit}',
  '{distance} from vehicle {other}, under the limit of {limit}': '{distance} von Fahrzeug {other}, unter der Grenze von {limit}', 'invalid value': 'ungültiger Wert', 'the swarm frame is not known yet': 'das Koordinatensystem des Schwarms ist noch nicht bekannt',
  'no position estimate': 'keine Positionsschätzung', '{have} vehicles are available, {need} are needed': '{have} Fahrzeuge sind verfügbar, {need} werden gebraucht', 'incarnation {got} is stale, {current} is running': 'Inkarnation {got} ist veraltet, {current} läuft',
  'two vehicles use system id {id}': 'zwei Fahrzeuge benutzen die Systemnummer {id}', '{what} is not running': '{what} läuft nicht', 'not permitted': 'nicht erlaubt', 'not supported': 'nicht unterstützt', 'not sent': 'nicht gesendet', 'vehicle {vehicle} has no payload "{payload}"': 'Fahrzeug {vehicle} hat keine Nutzlast „{payload}“',
  'there is no track {track}': 'es gibt keinen Fund {track}', 'preflight not met: {items}': 'Vorflug nicht erfüllt: {items}', clock: 'Uhr', 'there is no reference "{name}"': 'es gibt keine Vorgabe „{name}“',
} as const;
