//! What a server's answer says.

use serde::Deserialize;
use serde_json::Value;

use super::validate::line;

/// Longest piece of a server's own words in a message, characters.
const LONGEST: usize = 200;

/// What a model wrote.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Reply {
    pub text: String,
    /// Whether it stopped because it may write no more.
    pub is_cut_off: bool,
}

#[derive(Deserialize)]
struct Chat {
    choices: Option<Vec<Choice>>,
    error: Option<Value>,
}

#[derive(Deserialize)]
struct Choice {
    message: Message,
    finish_reason: Option<String>,
}

#[derive(Deserialize)]
struct Message {
    content: Option<Value>,
    refusal: Option<String>,
}

/// Reads the body of an answer with status 200.
///
/// # Errors
/// What is missing, in words.
pub(super) fn read(body: &[u8]) -> Result<Reply, String> {
    let chat: Chat = serde_json::from_slice(body).map_err(|_| format!("no JSON: {}", excerpt(body)))?;
    if let Some(error) = chat.error {
        return Err(line(&words_of(&error), LONGEST));
    }
    let choice = chat.choices.unwrap_or_default().into_iter().next().ok_or("no choices")?;
    let text = match choice.message.content {
        Some(Value::String(text)) => text,
        Some(Value::Array(parts)) => {
            parts.iter().filter_map(|part| part["text"].as_str().or_else(|| part.as_str())).collect()
        }
        // A refusal is an answer, too: it is asked once more.
        _ => choice.message.refusal.unwrap_or_default(),
    };
    Ok(Reply { text, is_cut_off: choice.finish_reason.as_deref() == Some("length") })
}

/// One line of what a server wrote: its message where there is one.
pub(super) fn excerpt(body: &[u8]) -> String {
    let text = serde_json::from_slice::<Value>(body).map_or_else(
        |_| String::from_utf8_lossy(&body[..body.len().min(4096)]).into_owned(),
        |value| words_of(&value),
    );
    let text = line(&text, LONGEST);
    if text.is_empty() { "it gave no reason".to_owned() } else { text }
}

/// The message in a server's error, wherever its dialect puts it.
fn words_of(value: &Value) -> String {
    let places = [&value["error"]["message"], &value["message"], &value["detail"], &value["error"], value];
    places.iter().find_map(|place| place.as_str()).map_or_else(|| value.to_string(), str::to_owned)
}

/// Whether a refusal is about the form in which the answer was asked for.
pub(super) fn is_about_format(body: &[u8]) -> bool {
    let text = String::from_utf8_lossy(&body[..body.len().min(64 << 10)]).to_lowercase();
    ["response_format", "json_schema", "json_object", "guided", "grammar", "structured output"]
        .iter()
        .any(|word| text.contains(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reply(body: &str) -> Result<Reply, String> {
        read(body.as_bytes())
    }

    #[test]
    fn content_is_a_text_or_parts() {
        let text = reply(r#"{"choices": [{"message": {"content": "a"}, "finish_reason": "length"}]}"#);
        assert_eq!(text, Ok(Reply { text: "a".to_owned(), is_cut_off: true }));
        let parts =
            r#"{"choices": [{"message": {"content": [{"type": "text", "text": "a"}, {"text": "b"}]}}]}"#;
        assert_eq!(reply(parts), Ok(Reply { text: "ab".to_owned(), is_cut_off: false }));
        let thinking = r#"{"choices": [{"message": {"content": null, "reasoning_content": "hm"}}]}"#;
        assert_eq!(reply(thinking).unwrap().text, "");
    }

    #[test]
    fn what_is_no_answer_is_said_in_the_server_s_words() {
        assert_eq!(reply(r#"{"choices": []}"#), Err("no choices".to_owned()));
        assert!(reply("<html>\nhello").unwrap_err().contains("<html> hello"));
        assert_eq!(reply(r#"{"error": {"message": "no such model"}}"#), Err("no such model".to_owned()));
        for body in [
            r#"{"error": {"message": "too hot"}}"#,
            r#"{"message": "too hot"}"#,
            r#"{"detail": "too hot"}"#,
            r#"{"error": "too hot"}"#,
            "too\nhot",
        ] {
            assert_eq!(excerpt(body.as_bytes()), "too hot");
        }
        assert!(is_about_format(br#"{"error": "response_format is not supported"}"#));
        assert!(!is_about_format(b"model not found"));
    }
}
